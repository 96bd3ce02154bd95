"""Files of loops with several channels: plants of any shape, arrays of tables, one sentence for whatever is wrong."""

import re
from fractions import Fraction

import pytest
from refusals import refusal

from lure.analysis import certify
from lure.analysis.questions.channel_problem import channel_problem
from lure.classes import Diagonal, NonlinearityClass, Sector
from lure.errors import InputError
from lure.files import loop_to_toml, parse_system
from lure.files.builtin import builtin_loop
from lure.nonlinearities import Quantiser, Saturation, Tanh
from lure.plants import as_plant

F = Fraction
THREE = "[plant]\nA = [[-1, 0], [1, -2]]\nB = [[1, 0, 0], [0, 1, 1]]\nC = [[1, 0], [0, 1], [1, 1]]\n"
ONE, PAIR = NonlinearityClass(sector=Sector(0, 1)), NonlinearityClass.slope_restricted(0, 1, odd=True)
CLASSES = "[[class]]\nsector = [0, 1]\n[[class]]\nslope = [0, 1]\nodd = true\nrepeated = 2\n"
GAIN = "[[class]]\ngain = [0, 1]\n"
LIMITS = "[[nonlinearity]]\nkind = 'saturation'\ngain = 2\nlimit = 1\nrepeated = 2\n[[nonlinearity]]\nkind = 'tanh'\n"
LIMITS += "scale = 1\ngain = 1\n"


def parsed(text, *settings):
    return parse_system(text, name="loop", source="loop.toml", settings=settings)


def test_the_classes_of_the_channels_in_order():
    found = parsed(THREE + CLASSES)
    assert found.classes == Diagonal((ONE, PAIR, PAIR), repeated=(1, 2))
    assert [list(block) for block in found.classes.blocks] == [[0], [1, 2]]
    assert found.block.D == ((0, 0, 0),) * 3
    assert parsed(THREE + GAIN * 3).classes.classes[2] == NonlinearityClass.constant_gain(0, 1)


MIXED = (
    "[[class]]\nnorm = 0.2\n[[nonlinearity]]\nkind = 'tanh'\nscale = 1\ngain = 1\nchannel = 2\n[[class]]\ndelay = 0.1\n"
)


def test_known_nonlinearities_stand_beside_classes_in_the_order_of_the_channels():
    found = parsed(THREE + MIXED)
    kinds = [NonlinearityClass.norm_bounded(F("0.2")), Tanh(gain=1, scale=1), NonlinearityClass.delayed(F("0.1"))]
    assert found.in_order == [(one, 1) for one in kinds]
    assert parsed(loop_to_toml(found)).in_order == found.in_order
    asked = (kinds[0], PAIR, kinds[2])  # tanh is odd with slopes in [0, 1]
    assert [channel_problem(*one).classes for one in ((found, None), (found.block, kinds))] == [Diagonal(asked)] * 2
    pair = parsed(THREE + GAIN + "[[nonlinearity]]\nkind = 'tanh'\nscale = 1\ngain = 1\nrepeated = 2\nchannel = 2\n")
    gain = NonlinearityClass.constant_gain(0, 1)
    assert channel_problem(pair, None).classes == Diagonal((gain, PAIR, PAIR), repeated=(1, 2))
    assert channel_problem(pair.block, [gain, "tanh(sigma)", "tanh(sigma)"]).classes.repeated == (1, 2)


@pytest.mark.parametrize(
    ("said", "why"),
    [
        (MIXED.replace("channel = 2", "channel = 0"), "channel is 0; give the number"),
        (MIXED.replace("channel = 2", "channel = 4"), "do not fill the 3 channels"),
        (MIXED.replace("channel = 2", "channel = 2\nrepeated = 2"), "do not fill the 3 channels"),
        (MIXED + "[[nonlinearity]]\nkind = 'tanh'\nscale = 1\ngain = 1\n", "needs one of its own"),
        (MIXED + GAIN, "do not fill the 3 channels"),
        (MIXED.replace("channel = 2\n", ""), "or channel = n in each [[nonlinearity]]"),
    ],
)
def test_a_mixture_that_leaves_a_channel_open_is_refused(said, why):
    with pytest.raises(InputError, match=re.escape(why)):
        parsed(THREE + said)


def test_a_nonlinearity_that_jumps_is_refused_beside_a_class():
    with pytest.raises(InputError, match="is not known to be locally Lipschitz"):
        channel_problem(parsed(THREE + GAIN * 3).block, [Quantiser(step=1), *[Sector(0, 1)] * 2])


def test_gains_that_change_slowly_are_read_and_written():
    rate = NonlinearityClass.varying_gain(0, 1, rate=F("0.1"))
    found = parsed(THREE + GAIN + "rate = 0.1\nrepeated = 2\n" + GAIN)
    assert found.classes == Diagonal((rate, rate, NonlinearityClass.constant_gain(0, 1)), repeated=(2, 1))
    one = parsed("[plant]\nnum = [1]\nden = [1, 1, 2]\n" + GAIN + "rate = 0.1\n")  # one channel is one of several
    assert one.classes == Diagonal((rate,))
    for loop in (found, one):
        again = parsed(loop_to_toml(loop))
        assert (again.block, again.classes) == (loop.block, loop.classes)


@pytest.mark.parametrize(
    ("said", "why"),
    [
        ("gain = [0, 1]\nrate = 0", "class.rate is 0; give how fast the gain may change"),
        ("gain = [0, 1]\nrate = -1", "class.rate is -1; give"),
        ("gain = [0, 1]\nrate = 'inf'", "class.rate"),
        ("sector = [0, 1]\nrate = 1", "rate is given without gain; give gain = [a, b]"),
        ("delay = 0", "class.delay is 0; give a positive bound"),
        ("delay = 1\nsector = [0, 1]", "delay is given beside other keys"),
        ("delay = 1\nnorm = 1", "delay is given beside other keys"),
        ("delay = 1\nrate = 2", "the rate of a delay is 2; give a number below 1"),
        ('memory = "relay"\nslope = [0, 1]', "class.memory is 'relay'; give 'play' or 'stop'"),
        ('memory = "play"', "memory is given beside other keys, or without the slope"),
        ('memory = "play"\nslope = [-1, 1]', "memory is given beside other keys, or without the slope"),
        ('memory = "play"\nslope = [0, 1]\nodd = true', "memory is given beside other keys"),
        ('memory = "play"\nslope = [0, inf]', "the slope of a play is inf"),
    ],
)
def test_rates_delays_and_memory_that_are_none_are_refused(said, why):
    with pytest.raises(InputError, match=re.escape(why)):
        parsed("[plant]\nnum = [1]\nden = [1, 1, 2]\n[class]\n" + said + "\n")


@pytest.mark.parametrize("rows", ['[["1/(s+1)", 0.5], ["0", "1/(s+2)"]]', '[["1/(s+1)", "1/2"], [0, "1/(s+2)"]]'])
def test_a_plant_of_formulas(rows):
    found = parsed(f"[plant]\ntransfer = {rows}\n")
    assert found.block == as_plant([["1/(s+1)", "1/2"], ["0", "1/(s+2)"]])
    assert (found.classes, found.nonlinearities, found.open) == (None, (), True)


def test_a_plant_without_dynamics_is_no_pair_of_coefficients():
    assert parsed("[plant]\ntransfer = [['1', '0'], ['0', '2']]\n").block.D == ((1, 0), (0, 2))


def test_the_nonlinearities_of_the_channels_in_order():
    found = parsed(THREE + LIMITS)
    assert found.nonlinearities == (Saturation(gain=2, limit=1), Saturation(gain=2, limit=1), Tanh(scale=1, gain=1))
    wide = "[[class]]\nslope = [0, 3]\nrepeated = 2\n[[class]]\nsector = [0, 1]\n"
    assert parsed(THREE + LIMITS + wide).classes.classes[2] == ONE


@pytest.mark.parametrize("name", ["secant-ring", "veenman-scherer-koroglu", "fetzer-scherer"])
def test_the_built_in_loops_read_back(name):
    loop = builtin_loop(name)
    again = parsed(loop_to_toml(loop))
    assert (again.block, again.classes, again.name) == (loop.block, loop.classes, loop.name)


@pytest.mark.parametrize("text", [THREE + CLASSES, THREE + LIMITS, THREE + GAIN * 3])
def test_any_loop_of_several_channels_reads_back(text):
    loop = parsed(text)
    again = parsed(loop_to_toml(loop))
    assert (again.block, again.classes, again.nonlinearities) == (loop.block, loop.classes, loop.nonlinearities)


def test_one_channel_may_stand_in_an_array():
    found = parsed("[plant]\ntransfer = '1/(s+1)'\n[[class]]\nsector = [0, 1]\n")
    assert (found.nonlinearity_class, found.classes) == (ONE, None)


def test_a_table_of_an_array_is_changed_by_its_number():
    found = parsed(THREE + CLASSES, "class.2.odd=false", "class.1.sector=0 2")
    assert found.classes.classes[1].odd is False
    assert found.classes.classes[0].sector == Sector(0, 2)


@pytest.mark.parametrize(
    ("text", "settings", "said"),
    [
        (THREE + GAIN * 2, (), r"class: the tables \[\[class\]\] are about 2 channels, and the plant has 3 of them"),
        (THREE + "[class]\nsector = [0, 1]\n", (), "about 1 channel, and the plant has 3"),
        (THREE + "[class]\nsector = [0, 1]\n" + GAIN, (), r"loop.toml has both \[class\] and \[\[class\]\]; give"),
        (
            THREE + "[[class]]\nsectr = [0, 1]\n",
            (),
            r"\[\[class\]\] number 1: unknown key class.sectr; did you mean class",
        ),
        (THREE + GAIN + "[[class]]\nsector = [3, 1]\n", (), r"\[\[class\]\] number 2: class.sector is \[3, 1\]"),
        (
            THREE + GAIN + "[[class]]\nodd = true\n",
            (),
            r"\[\[class\]\] number 2: class: neither sector, slope, gain nor relu",
        ),
        (THREE + "[[class]]\ngain = [0, 1]\nodd = true\n", (), "gain is given beside other keys"),
        (THREE + "[[class]]\ngain = [0, 1]\nrepeated = 0\n", (), "class.repeated is 0; give in how many channels"),
        (THREE + "[[nonlinearity]]\ngain = 2\n", (), r"\[\[nonlinearity\]\] number 1: nonlinearity.kind is missing"),
        (
            THREE + LIMITS + "[[class]]\nsector = [0, 3]\nrepeated = 3\n",
            (),
            "one nonlinearity acts in the channels 1 to 3",
        ),
        (THREE + LIMITS + "[[class]]\nsector = [0, 1]\n" * 3, (), "the class is phi in the sector .0, 1. but the"),
        (
            THREE + CLASSES,
            ("class.odd=true",),
            r"the file has 2 tables \[\[class\]\]; say which one, such as class.2.odd",
        ),
        (THREE + CLASSES, ("class.3.odd=true",), "say which one"),
        (THREE + "[class]\nsector = [0, 1]\n", ("class.1.odd=true",), r"there is no array of tables \[\[class\]\]"),
        (THREE + "D = [[1, 2], [3, 4]]\n", (), "plant: D is 2 x 2, and the plant has 3 inputs and 3 outputs"),
        ("[plant]\nA = [[-1]]\nB = [[1, 2]]\nC = [[1]]\n", (), "plant: it has 2 inputs and 1 output"),
        ("[plant]\ntransfer = [['1/(s+1)', 's'], ['0', '0']]\n", (), r"plant: transfer\[0\]\[1\]: .*improper"),
        ("[plant]\ntransfer = [['1/(s+1)', '0'], ['0']]\n", (), "plant.transfer has rows of different lengths"),
        ("[plant]\ntransfer = ['1/(s+1)', '0']\n", (), "or rows of them for several channels"),
        (
            "[plant]\ntransfer = [['exp(-s)', '0'], ['0', '0']]\n",
            (),
            r"transfer\[0\]\[0\] has dead time and is not strictly",
        ),
        (
            "[plant]\ntransfer = '1/(s+1)'\n[[class]]\nsector = [0, 1]\nrepeated = 2\n",
            (),
            "about 2 channels, and the plant",
        ),
        ("class = [5]\n[plant]\ntransfer = '1/(s+1)'\n", (), r"\[\[class\]\] number 1: class is 5; give a table"),
    ],
)
def test_what_is_wrong_is_one_sentence(text, settings, said):
    assert re.search(said, refusal(parsed, text, *settings))


LATE = "[plant]\ntransfer = [['1/(s+1)', '0'], ['0', 'exp(-s)/(s+2)']]\n"


@pytest.mark.slow_for("norm = 0.5\\nsize = 1\\ndynamics")
@pytest.mark.parametrize(
    ("text", "given"),
    [
        (
            "norm = 0.5\nsize = 1\ndynamics = 'linear time-invariant'\n",
            NonlinearityClass.norm_bounded(F(1, 2), dynamics="linear time-invariant"),
        ),
        ("relu = true\n", NonlinearityClass.relu()),
    ],
)
def test_operators_and_rectifiers_beside_dead_times_in_a_matrix(text, given):
    # |exp(-i w)/(i w + 2)| <= 1/2 and |1/(i w + 1)| <= 1: small gain, which Popov's and the circle criterion contain
    found = parsed(LATE + f"[[class]]\n{text}" * 2)
    assert found.classes is not None
    assert found.classes.classes == (given, given)
    assert parsed(loop_to_toml(found)).classes == found.classes
    assert certify(found).verdict.name == "PROVED"


def test_rectifiers_are_read_and_written_back():
    text = THREE + "[[class]]\nrelu = true\n[[class]]\nrelu = true\nslope = [0.1, 2]\nrepeated = 2\n"
    found = parsed(text)
    leaky = NonlinearityClass.relu(F(1, 10), 2)
    assert found.classes == Diagonal((NonlinearityClass.relu(), leaky, leaky), repeated=(1, 2))
    assert parsed(loop_to_toml(found)).classes == found.classes
    assert str(leaky) == "phi = 2 max(sigma, 0) + 0.1 min(sigma, 0)"
    assert leaky.scaled(F(3)) == NonlinearityClass.relu(F(1, 10), 6)
    # around one channel the theorems on several are asked
    alone = parsed("[plant]\nnum = [1]\nden = [1, 1]\n[class]\nrelu = true\n")
    assert (alone.block.inputs, alone.classes) == (1, Diagonal((NonlinearityClass.relu(),)))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (THREE + "[[class]]\nrelu = true\nodd = true\nrepeated = 3\n", "relu is given beside other keys"),
        (THREE + "[[class]]\nrelu = true\nsector = [0, 1]\nrepeated = 3\n", "give relu = true alone, or with slope"),
        (THREE + "[[class]]\nrelu = true\nslope = [0, inf]\nrepeated = 3\n", "bounds differ or are infinite"),
        (THREE + "[[class]]\nrelu = 1\nrepeated = 3\n", "class.relu is 1; give true or false"),
        (THREE + "[[class]]\nrelu = true\ngain = [0, 1]\nrepeated = 3\n", "gain is given beside other keys"),
        (
            "[plant]\ntransfer = 'exp(-s)/(s+1)'\n[class]\nrelu = true\n",
            "relu in channel 1 needs a plant with exact rational entries; leave the dead time out, or this",
        ),
        (
            LATE + "[[class]]\nrelu = true\n[[class]]\nmemory = 'play'\nslope = [0, 1]\n",
            "class: memory in channel 2 needs a plant with exact rational entries",
        ),
        (
            THREE + LIMITS + "[[class]]\nrelu = true\nrepeated = 3\n",
            "the class is phi = max(sigma, 0) alone, and a nonlinearity is given beside it",
        ),
        (
            THREE + LIMITS + "[[class]]\ngain = [0, 1]\nrepeated = 3\n",
            "the class is phi = g sigma, g in [0, 1] alone, and a nonlinearity is given beside it",
        ),
    ],
)
def test_a_rectifier_or_a_gain_with_other_properties_is_refused(text, sentence):
    assert sentence in refusal(parsed, text)
