"""The help of the `lure` command: 80 columns, examples that run, nothing heavy loaded to print it."""

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
COMMANDS = (
    *("report", "init", "systems", "reproduce", "doctor", "explore", "analyse", "max-sector", "max-slope", "gain"),
    *("region", "sweep"),
    *("certify", "verify", "explain", "export"),
    *("simulate", "compare", "response", "bifurcation", "basin", "sector"),
)


def helps(lure):
    return {command: lure(*command.split(), "--help")[1] for command in ("", *COMMANDS)}


def test_help_fits_80_columns_and_shows_examples_before_options(lure):
    for command, text in helps(lure).items():
        assert max(map(len, text.splitlines())) <= 80
        assert not re.search(r"[`\\]b|\[bold", text)
        start, options = text.index("Examples:\n"), text.index("Options:\n")
        assert start < options
        assert re.match(rf"    lure {command or 'max-sector'}", text[start:].splitlines()[1])
        assert "..." not in text.partition("Commands:")[2]  # no summary is cut short


def test_help_is_what_no_command_and_h_print_too(lure):
    assert lure() == lure("-h") == lure("--help")
    assert lure("report", "-h") == lure("report", "--help")


def test_the_examples_of_the_help_texts_are_commands_that_exist(lure):
    for text in helps(lure).values():
        for used in re.findall(r"\blure ([\w-]+)", text.partition("Examples:")[2].partition("\n\n")[0]):
            assert used in COMMANDS


def test_the_root_help_reads_as_written(lure):
    assert lure("--help")[1].partition("Options:")[0] == (
        "Usage: lure [OPTIONS] COMMAND [ARGS]...\n\n"
        "  For which nonlinearities is a Lur'e loop stable, and how do we know?\n\n"
        "  A linear block in feedback with a nonlinearity of a given sector or slope:\n"
        "  how far it is proved stable, by which criterion, and where a counterexample\n"
        "  begins.\n\n"
        "  Examples:\n"
        '    lure max-sector --num "1" --den "1 3 2 0"     the largest stable sector\n'
        '    lure max-slope --odd --transfer "1/(s+1)^3"   the largest slope of odd phi\n'
        "    lure init --loop                              write plant.toml, to edit\n"
        "    lure report plant.toml                        all there is to say, as a page\n"
        "    lure report kalman-fitts                      the same for a built-in loop\n"
        "    lure report                                   the rod of the paper\n"
        "    lure simulate paper-rod -o run.nc             its motion, to rounding\n"
        "    lure compare paper-rod                        how far schemes are from it\n"
        "    lure region plant.toml                        from where a loop recovers\n"
        "    lure certify plant.toml                       the proof alone, as a file\n"
        "    lure verify certificate.json                  check it without trusting lure\n"
        "    lure explore plant.toml                       drag k, theta in the browser\n"
        "    lure reproduce paper                          the paper's claims, one by one\n\n"
        "  Exit status: 0 proved, 10 inconclusive, 11 refuted, 2 bad input,\n"
        "  1 a bug in lure, 130 interrupted.\n\n"
    )


def test_help_loads_nothing_heavy():
    script = "import sys; from lure.analysis.cli import main; main(['--help']); print('LOADED', *sys.modules)"
    run = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    loaded = {name.split(".")[0] for name in run.stdout.partition("LOADED ")[2].split()}
    assert not loaded & {"numpy", "scipy", "sympy", "control", "matplotlib", "flint", "pydantic", "jinja2"}


def test_help_costs_less_than_half_a_second_more_than_python_itself():
    def seconds(*arguments):  # of processor time, which does not depend on what else the machine is doing
        times = []
        for _ in range(3):
            before = os.times()
            subprocess.run([sys.executable, *arguments], cwd=ROOT, capture_output=True, check=True)
            after = os.times()
            times.append(sum(after[2:4]) - sum(before[2:4]))
        return min(times)

    assert seconds("-m", "lure.analysis.cli", "--help") < seconds("-c", "pass") + 0.5


def test_a_shell_completes_the_names_of_commands():
    asked = {"_LURE_COMPLETE": "complete_bash", "COMP_WORDS": "lure max-s", "COMP_CWORD": "1"}
    script = "import sys; sys.argv = ['lure']; from lure.analysis.cli import main; sys.exit(main())"
    run = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, env=os.environ | asked, capture_output=True, text=True, check=True
    )
    assert run.stdout.split() == ["max-sector", "max-slope"]
    assert run.stderr == ""
