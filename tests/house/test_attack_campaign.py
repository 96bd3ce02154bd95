"""The campaign of attacks: each attack finds what is known to be false, loops follow from the seed, files go on."""

import importlib.util
import json
import math
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from lure import Diagonal, NonlinearityClass, Sector

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture(scope="module", autouse=True)
def rooms():
    sys.path.append(str(BENCHMARKS))
    yield
    sys.path.remove(str(BENCHMARKS))


@pytest.fixture(scope="module")
def script(rooms):
    spec = importlib.util.spec_from_file_location("campaign_of_attacks", BENCHMARKS / "attacks.py")
    module = importlib.util.module_from_spec(spec)
    path = list(sys.path)
    spec.loader.exec_module(module)
    sys.path[:] = path
    return module


def loop(n, d, one, *, discrete=False, delay=0):
    from campaign.draws import Drawn
    from campaign.exact import Rational

    sides = ([Fraction(str(v)) for v in side] for side in (n, d))
    return Drawn(Rational(*sides, discrete, Fraction(str(delay))), one)


def varying(k):
    return NonlinearityClass(sector=Sector(0, k), time_varying=True)


SLOPE, SLOW = NonlinearityClass.slope_restricted, NonlinearityClass.varying_gain
FALSE = {  # the attack, and a loop of which it is false that 0 attracts every solution
    "1/(s + 1)^3 is stable up to 8": ("constant", [1], [1, 3, 3, 1], Sector(0, 8.01), {}),
    "an integrator is not stable with the gain 0": ("constant", [1], [1, 1, 0], Sector(0, 1), {}),
    "z = -1 with the gain 2": ("constant", [1], [1, 1], Sector(0, 2), {"discrete": True}),
    "exp(-s)/(s + 1) is stable up to 2.26": ("constant", [1], [1, 1], Sector(0, 2.3), {"delay": 1}),
    "gains that jump between 0 and 60": ("jumping", [1], [1, "0.2", 1], varying(4), {}),
    "gains that jump in discrete time": ("jumping", ["0.5"], [1, "-1.6", "0.9"], varying(1), {"discrete": True}),
    "dt-6 with slopes up to 1.1": ("orbits", [2, "0.92"], [1, "-0.5", 0], SLOPE(0, 1.1), {"discrete": True}),
    "a cubic root near 0": ("functions", [-1], [1, 1, 3, 0], SLOPE(0, 2.5), {}),
    "two stays, in short words": ("words", [1], [1, "0.2", 1], varying(4), {}),
    "short words in discrete time": ("words", ["0.5"], [1, "-1.6", "0.9"], varying(1), {"discrete": True}),
    "ramps up and down in 1 s each": ("ramps", [1], [1, "0.02", 1], SLOW(0, 2, rate=2), {}),
    "ramps in discrete time": (
        "ramps",
        ["0.5"],
        [1, "-1.6", "0.98"],
        SLOW(0, 1, rate=Fraction(1, 2)),
        {"discrete": True},
    ),
    "dt-6 with u = 0, -1, 0, 1": (
        "integer_orbits",
        [2, "0.92"],
        [1, "-0.5", 0],
        Sector(0, Fraction(125, 192)),
        {"discrete": True},
    ),
    "a dead time by the method of steps": ("late", [1], [1, 1], varying(2.6), {"delay": 1}),
}


@pytest.mark.slow_for("a cubic root near 0", "a dead time by the method of steps")
@pytest.mark.parametrize("name", FALSE)
def test_an_attack_finds_what_is_false(name):
    from campaign import members, quick

    attack, n, d, one, more = FALSE[name]
    room = members if hasattr(members, attack) else quick
    one = NonlinearityClass(sector=one) if isinstance(one, Sector) else one
    case = loop(n, d, one, **more)
    randoms = map(np.random.default_rng, range(8))
    assert any(getattr(room, attack)(case, "0 attracts every motion", random) for random in randoms)


def circle(case, name="circle", **multiplier):
    """What the inequality says against a certificate for the loop."""
    from campaign.quick import inequality

    return inequality(case, {"theorem": name, "multiplier": multiplier, "system": {"kind": "transfer"}})


# 1/(s + 1)^2: Re 1/(1 + i w)^2 is least at w^2 = 3, -1/8. 1/(s (s + 1)), k: 1/k + Re (1 + i w theta)/(i w (i w + 1)) =
# 1/k + (theta - 1)/(1 + w^2). 1/(z - 1/2): Re at z = -1 is -2/3.
@pytest.mark.parametrize(
    ("n", "d", "high", "discrete", "name", "theta"),
    [
        ([1], [1, 2, 1], 8, False, "circle", {}),
        ([1], [1, "1.01", "0.01"], None, False, "popov", {"theta": "1"}),
        ([1], [1, "-0.5"], "1.5", True, "circle", {}),
    ],
)
def test_the_inequality_is_found_false_just_beyond_its_end(rooms, n, d, high, discrete, name, theta):
    def said(share):
        top = math.inf if high is None else Fraction(high) * share
        return circle(loop(n, d, NonlinearityClass(sector=Sector(0, top)), discrete=discrete), name, **theta)

    if high is None:  # Re (1 + i w theta)/((i w + 1)(i w + 1/100)) >= 0 for theta >= 100/101
        assert said(1) == ""
        theta = {"theta": "0.99"}
        assert "the inequality of popov" in said(1)
        return
    assert said(Fraction(999, 1000)) == ""
    assert f"the inequality of {name}" in said(Fraction(1001, 1000))


# 1/(s + 1)^3: 7.99 is stable, 8 is not; the saturation with slope 1 up to 1 has the sector and slopes [0, 1].
def test_false_counterexamples_are_seen():
    from campaign.exact import Piecewise
    from campaign.replay import replayed

    case = loop([1], [1, 3, 3, 1], NonlinearityClass(sector=Sector(0, 9)))
    assert replayed(case, {"method": "linear-gain", "gain": "8"}) == ""
    assert "stable" in replayed(case, {"method": "linear-gain", "gain": "799/100"})
    assert "no member" in replayed(case, {"method": "linear-gain", "gain": "10"})
    one = Fraction(1)
    graph = Piecewise(((-one, -one), (one, one)), Fraction(0), Fraction(0))
    assert graph.belongs(SLOPE(0, 1, odd=True))
    assert not graph.belongs(SLOPE(0, 0.9))
    assert not Piecewise(((-one, -one), (one, one)), Fraction(0), one).belongs(SLOPE(0, 1, odd=True))
    # sigma+ = u with u = -sigma: 1, -1, 1, ..
    turning = loop([1], [1, 0], NonlinearityClass(sector=Sector(0, 1)), discrete=True)
    proof = {"method": "orbit", "points": [["-1", "-1"], ["1", "1"]], "left": "0", "right": "0"}
    assert replayed(turning, proof | {"u": ["-1", "1"], "sigma": ["1", "-1"]}) == ""
    assert "no solution" in replayed(turning, proof | {"u": ["-1", "-1"], "sigma": ["1", "1"]})


def test_the_forms_of_a_loop_are_one_loop():
    from campaign.exact import plus, where
    from campaign.forms import FORMS, brought

    random = np.random.default_rng(1)
    case = loop(["0.5", 2], [1, 2, 3, 4], SLOPE(Fraction(-1, 4), 3))
    for name in FORMS:
        other = brought(case, name, random)
        for g in (Fraction(-1, 4), Fraction(1, 3), Fraction(3), Fraction(50)):
            plant, gain = other.case.plant, g * other.factor + other.offset
            here = where(plus(case.plant.d, case.plant.n, g), discrete=False)
            assert where(plus(plant.d, plant.n, gain), discrete=False) == here, (name, g)


@pytest.mark.parametrize("kind", ["continuous", "critical", "boxes"])
def test_a_loop_follows_from_the_seed_and_nothing_is_found(script, kind):
    counts, faults = script.guarded(kind, 3)
    again, _ = script.guarded(kind, 3)
    assert faults == []
    assert counts["loops"] == 1
    assert counts == again


def test_gains_of_several_channels_are_replayed(rooms):
    from campaign.several import Channels, channels_replayed

    one, zero = Fraction(1), Fraction(0)
    classes = Diagonal((NonlinearityClass(sector=Sector(0, 3)),) * 2)
    case = Channels(
        [[-one, zero], [zero, -one]],
        [[one, zero], [zero, one]],
        [[zero, -one], [-one, zero]],
        [[zero] * 2] * 2,
        classes,
        False,
    )
    assert channels_replayed(case, {"method": "linear-gains", "gains": ["1", "1"]}) == ""  # -1 +- g
    assert "stable" in channels_replayed(case, {"method": "linear-gains", "gains": ["1/2", "1/2"]})
    assert "no members" in channels_replayed(case, {"method": "linear-gains", "gains": ["4", "4"]})


def test_a_campaign_goes_on_where_its_file_ends(script, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(
        script, "guarded", lambda kind, i: (script.Counter(loops=1, PROVED=2), [f"{kind} {i}"] * (i == 7))
    )
    state = tmp_path / "chunks.jsonl"
    assert script.campaign(state, math.inf, ["continuous", "channels"], 60) == 1
    whole = state.read_text()
    ends = script.done(state)[0]
    with state.open("a") as file:
        file.write(json.dumps({"kind": "continuous", "from": ends["continuous"]})[:-5])  # killed while it wrote
    assert script.done(state)[0] == ends
    script.campaign(state, math.inf, ["continuous", "channels"], 90)
    assert state.read_text().startswith(whole)
    ends, counts, faults = script.done(state)
    # every chunk of both runs counts: those after the torn line begin where those before it ended
    chunks = [json.loads(line) for line in state.read_text().splitlines() if line.endswith("}")]
    assert len(chunks) == len(state.read_text().splitlines()) - 1
    assert sum(ends.values()) == sum(chunk["to"] - chunk["from"] for chunk in chunks)
    assert sum(ends.values()) == sum(found["loops"] for found in counts.values()) >= 150
    assert sorted(faults) == ["channels 7", "continuous 7"]
    assert "claim: 0" in capsys.readouterr().out


# x' = -k x(t - 1) decays as exp(W(-k) t), W Lambert's function: -.25917 at k = .2; 3 is past pi/2, where it grows
@pytest.mark.parametrize(
    ("pieces", "k", "exponent"), [(1, "0.2", -0.2591711018), (2, "0.2", -0.2591711018), (2, 3, 0.4669978579)]
)
def test_the_slowest_solution_with_dead_time_is_found(rooms, pieces, k, exponent):
    from campaign.late import Late, slowest

    plant = Late({pieces: [Fraction(1)]}, [Fraction(0), Fraction(1)], Fraction(1, pieces))
    found = slowest(plant, "sector", Fraction(k), Fraction(k), np.random.default_rng(0))
    assert found == pytest.approx(exponent, abs=1e-9)


# x' = x - phi(x), phi(x) = 2 x up to the limit 1: equilibria at +-1, between them 0 attracts
def test_starts_lie_at_the_edges(rooms):
    from campaign.known_nonlinearities import starts_in, starts_outside

    from lure import Saturation
    from lure.analysis import region

    found = region(([[1]], [[1]], [[1]], [[0]]), Saturation(gain=2, limit=1))
    x = np.array([[1.0], [-1.0]])
    assert starts_in(found.sets[0], x) == pytest.approx(np.array([[0.999], [-0.999]]), abs=1e-6)
    assert np.sort(starts_outside(found.outside[0], x), axis=0) == pytest.approx(
        np.array([[-1.001], [1.001]]), abs=1e-6
    )
