"""What a report is asked beside stability, ``[report] ask``: not said to be open, refused where it has no answer."""

import pytest

from lure import Sector
from lure.analysis import decay_rate, steady_response
from lure.analysis.report import report_on
from lure.analysis.report.loop.asked import ASKED
from lure.errors import InputError
from lure.files import find_system

FILE = """
[plant]
num = [1]
den = [1, 3, 2]
[class]
sector = [0, 1]
[report]
ask = ["{}"]
"""


def made(tmp_path, question):
    path = tmp_path / "loop.toml"
    path.write_text(FILE.format(question))
    return find_system(str(path))


@pytest.mark.slow
def test_what_was_asked_is_not_said_to_be_open(tmp_path):
    said = str(report_on(made(tmp_path, "rate"), output=tmp_path / "out"))
    assert "exp(-" in said
    assert "a rate of decay" not in said
    assert "a bound on the size of the solution, anything about external inputs" in said


# 1/(s (s + 1) (s + 2)) with phi = 0 stays where it is: no rate is true of the sector [0, 1]
@pytest.mark.slow
def test_what_was_asked_and_not_proved_is_still_said_not_to_be_shown(tmp_path):
    path = tmp_path / "loop.toml"
    path.write_text(FILE.format("rate").replace("[1, 3, 2]", "[1, 3, 2, 0]"))
    report = report_on(find_system(str(path)))
    assert str(report.asked["rate"].verdict) == "REFUTED"
    assert "Not shown: a rate of decay" in str(report)


@pytest.mark.parametrize("question", ["region", "steady"])
def test_a_question_without_an_answer_is_refused_by_its_key(tmp_path, question):
    # a region is one of a known nonlinearity, a response one of slopes: the file has none
    with pytest.raises(InputError, match=rf"^report\.ask has '{question}', "):
        report_on(made(tmp_path, question), output=tmp_path / "out")
    assert not (tmp_path / "out").exists()


# of a plant with parameters the gain needs [performance]: that was said after the rate had been searched for
def test_what_has_no_answer_is_refused_before_the_questions_ahead_of_it_are_answered(tmp_path, monkeypatch):
    path = tmp_path / "loop.toml"
    path.write_text(FILE.format('rate", "gain').replace("[1, 3, 2]", '[1, "a"]') + "[plant.parameters]\na = [1, 2]\n")
    asked = []
    monkeypatch.setitem(ASKED, "rate", ASKED["rate"]._replace(answer=lambda *_, **given: asked.append(given)))
    with pytest.raises(InputError, match=r"^report\.ask has 'gain', .*give \[performance\]"):
        report_on(find_system(str(path)))
    assert not asked


# x' = x - phi grows like e^t with phi = 0, x+ = 2 x - phi like 2^t: nothing there decays
@pytest.mark.parametrize("plant", ["1/(s - 1)", "1/(z - 2)"])
def test_the_figure_of_what_grows_does_not_say_that_it_decays(plant):
    said = ASKED["rate"].caption(decay_rate(plant, Sector(0, 0.5)))
    assert "no solution of any member grows faster than, certified. Orange: a member that grows as fast." in said
    assert "decays" in ASKED["rate"].caption(decay_rate("1/(s + 1)", Sector(0, 0.5)))


# a sine that is sampled need not be periodic, and the amplitude is the least upper bound of all samples
@pytest.mark.slow
def test_the_amplitude_in_samples_is_not_said_to_be_that_of_a_period():
    found = steady_response("1/(z - 1/2)", "sigma/4 + tanh(sigma)/8", {"amplitude": 1, "omega": 1})
    assert found.plot().get_ylabel() == "largest |z| of a steady response"
