"""The commands on loops with several channels."""

import json

import pytest

TWO = """
[plant]
A = [[-1, 0], [0, -2]]
B = [[0, 1], [-1, 0]]
C = [[1, 0], [0, 1]]

[[class]]
slope = [0, 2]
[[class]]
slope = [0, 1]
"""


@pytest.fixture
def file(tmp_path):
    (tmp_path / "two.toml").write_text(TWO)
    return str(tmp_path / "two.toml")


@pytest.mark.slow
def test_the_largest_factor_of_the_classes_of_a_file(lure, file):
    # det(1 + H G) = 1 + g_1 g_2/((s+1)(s+2)): stable for all gains above 0
    status, out, _ = lure("max-slope", "--system", file)
    assert status == 0
    assert out.startswith(
        "Classes: phi_1 with slope in [0, 2]; phi_2 with slope in [0, 1]; every upper\nbound times k."
    )
    assert "by diagonal-popov (certified)" in out
    data = json.loads(lure("max-sector", "--system", file, "--json")[1])
    assert data["verdict"] == "PROVED"
    assert data["classes"]["classes"][0]["slope"]["upper"] in (2, "2")


def test_a_certificate_that_both_checkers_accept(lure, file, tmp_path):
    target = str(tmp_path / "two.json")
    status, out, _ = lure("certify", file, "-o", target)
    assert status == 0
    assert "theorem: diagonal-popov" in out
    assert lure("verify", target, "--second")[0] == 0
    status, out, _ = lure("certify", "secant-ring", "--sector", "0", "3", "-o", str(tmp_path / "against.json"))
    assert status == 11  # 3 * 3 > 8
    assert json.loads((tmp_path / "against.json").read_text())["proof"]["gains"][0] != "0"


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (("max-sector", "--system", "secant-ring", "--lower", "1"), "--lower is for one nonlinearity, and secant-ring"),
        (("max-slope", "--system", "secant-ring", "--odd"), "--odd is for one nonlinearity"),
        (("max-slope", "--system", "secant-ring"), "the class of channel 1 has no slope bounds"),
        (("max-sector", "--system", "secant-ring", "--criterion", "park"), "does not answer this question"),
        (("certify", "secant-ring", "--method", "cover", "-o", "-"), "several nonlinearities are proved by a matrix"),
        (("analyse", "secant-ring", "--set", "class.odd=true"), "say which one, such as class.2.odd"),
        (("analyse", "secant-ring", "--plot", "map.pdf"), "give a name that ends in .svg or .png"),
    ],
)
def test_what_is_refused_is_one_sentence_and_status_2(lure, command, said):
    status, out, err = lure(*command)
    assert (status, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1


def test_the_systems_are_shown(lure):
    out = lure("systems", "fetzer-scherer")[1]
    assert "Plant: 3 states, 4 inputs and 4 outputs" in out
    assert "Class: phi_1 = ... = phi_4 with slope in [0, 0.5]" in out


@pytest.mark.slow
def test_the_map_as_a_picture(lure, tmp_path, monkeypatch):
    from lure.analysis.questions import channel_map

    monkeypatch.setattr(channel_map, "_DIRECTIONS", (0.0,))
    picture = tmp_path / "map.svg"
    status, _, _ = lure("analyse", "secant-ring", "--plot", str(picture), "-q")
    assert status == 0
    assert "<svg" in picture.read_text()
