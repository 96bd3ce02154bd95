"""Paragraphs and help texts in lines of 80 columns."""

from __future__ import annotations

import textwrap

WIDTH = 80


def wrapped(text: str, *, indent: int) -> list[str]:
    """A paragraph in lines of 80 columns, the later ones indented; words longer than that stay whole.

    Parameters
    ----------
    text : str
        The paragraph; blanks before it indent the first line.
    indent : int
        Blanks before the second and later lines.
    """
    printable = "".join(sign if sign.isprintable() else ascii(sign)[1:-1] for sign in text)
    return textwrap.wrap(
        printable.strip(),
        WIDTH,
        initial_indent=" " * (len(printable) - len(printable.lstrip())),
        subsequent_indent=" " * indent,
        break_long_words=False,
        break_on_hyphens=False,
    )


# The help texts: what a command is for, then examples, each within 80 columns.

_STATUS = """
\b
Exit status: 0 proved, 10 inconclusive, 11 refuted, 2 bad input,
1 a bug in lure, 130 interrupted.
"""
_BEST_SO_FAR = """
\b
When --seconds are over, or on Ctrl-C, the best bounds so far are printed and
said to be that; the exit status is that of the verdict reached.

\b
Exit status: 0 proved, 10 inconclusive, 11 refuted, 2 bad input,
130 interrupted before anything was found.
"""

ROOT = """For which nonlinearities is a Lur'e loop stable, and how do we know?

A linear block in feedback with a nonlinearity of a given sector or slope: how
far it is proved stable, by which criterion, and where a counterexample begins.

\b
Examples:
  lure max-sector --num "1" --den "1 3 2 0"     the largest stable sector
  lure max-slope --odd --transfer "1/(s+1)^3"   the largest slope of odd phi
  lure init --loop                              write plant.toml, to edit
  lure report plant.toml                        all there is to say, as a page
  lure report kalman-fitts                      the same for a built-in loop
  lure report                                   the rod of the paper
  lure simulate paper-rod -o run.nc             its motion, to rounding
  lure compare paper-rod                        how far schemes are from it
  lure region plant.toml                        from where a loop recovers
  lure certify plant.toml                       the proof alone, as a file
  lure verify certificate.json                  check it without trusting lure
  lure explore plant.toml                       drag k, theta in the browser
  lure reproduce paper                          the paper's claims, one by one
"""
ROOT += _STATUS

REPORT = """Analyse a system and write the report.

\b
Examples:
  lure report
  lure report plant.toml -o results/plant
  lure report kalman-fitts
  lure report plant.toml --set class.odd=true
  lure report paper-rod-figure-8 --set rod.damping=8e-4 --set rod.gap=0.01
  lure report rod.toml --set "force.g=2*sin(4*t)"
  lure report --json --quiet | python -m json.tool
  lure report plant.toml -o plant.pdf

\b
The directory gets report.html, report.json and the figures as SVG and PNG,
with --pdf report.pdf too; a name that ends in .pdf is that PDF alone.
It is replaced as a whole, once all is done, and only if it is empty or holds
a report.  `lure systems` lists the built-in systems, `lure init` and
`lure init --loop` write files that explain every key.

\b
--seconds limit the criteria and searches for a loop; simulations and drawings
come on top.  Ctrl-C ends them too, and the report says what was found.
"""
REPORT += _STATUS

INIT = """Write a commented file to start from.

\b
Examples:
  lure init && lure report rod.toml
  lure init --loop && lure report plant.toml
  lure init --loop servo.toml
  lure init --kind delay && lure report delay.toml
  lure init --notebook my-loop.ipynb && jupyter lab my-loop.ipynb
  lure init --test test_phi.py && pytest test_phi.py

\b
The TOML file describes the paper's rod, or a plant with --loop; with --kind a
rod with contacts, a delay, a disturbance, a memory, an unknown operator.  The
notebook takes your plant and your nonlinearity from the question to Popov's
plot, a proof and a test; as .py it is a script.  The test fails where a
nonlinearity leaves its sector or its slope bounds.
"""

SYSTEMS = """List the built-in systems, or show one of them.

\b
Examples:
  lure systems
  lure systems kalman-fitts
  lure systems kalman-fitts --toml > plant.toml
  lure systems paper-rod-figure-8 --toml > rod.toml
"""

DOCTOR = """Say what is installed, and what is missing.

\b
Examples:
  lure doctor
"""

REPRODUCE = """Redraw the paper's figures and check its claims.

\b
Examples:
  lure reproduce paper
  lure reproduce paper -o paper --json

\b
For each claim: what the printed equations give, what the corrected ones give,
and what the rod itself does.  The directory gets paper.html, paper.json and
the figures; it is replaced as a whole.
"""

ANALYSE = """Run every criterion and counterexample search on a loop.

\b
Examples:
  lure analyse plant.toml
  lure analyse kalman-fitts --json
  lure analyse plant.toml --set class.odd=true
  lure analyse plant.toml --seconds 10 -v
  lure analyse secant-ring --plot map.svg

\b
One table: for each class of nonlinearities how far it is proved stable, by
which criterion, and the smallest class found with a member that destabilises.
With several channels the numbers are factors of every upper bound; with two,
--plot draws the map of both upper bounds.
"""
ANALYSE += _BEST_SO_FAR

MAX_SECTOR = """Print the largest sector for which a loop is stable.

\b
Examples:
  lure max-sector --num "1" --den "1 3 2 0" --criterion popov
  lure max-sector --num "2 0.92" --den "1 -0.5 0" --dt 1 --json
  lure max-sector --transfer "4/((s-1)*(s/3+1))" --lower 1/2
  lure max-sector plant.toml --time-varying --full

\b
H is the block from mu to sigma, and mu = -phi(sigma) with
K1 sigma^2 <= sigma phi(sigma) <= k sigma^2.  Numbers are exact: 0.1 is 1/10.
Of a system with several channels, or a constant gain, the largest factor of
all upper bounds of its classes is printed.  What the [class] of one channel
says beside its upper bound holds: time_varying, the lower bound.
"""
MAX_SECTOR += _BEST_SO_FAR

RATE = """Print how fast every solution decays, from both sides.

\b
Examples:
  lure rate plant.toml
  lure rate plant.toml --set class.time_varying=true --json
  lure rate plant.toml -o rate.json              the proof, as a file
  lure verify rate.json --second                 check it with both checkers

\b
In continuous time |x(t)| <= c exp(-rate t) |x(0)|: the first number is proved
for the class, and no larger rate than the second is true.  In discrete time
|x(t)| <= c rate^t |x(0)|: no smaller factor than the first number is true, and
the second is proved.  c is one for the whole class.  Where a member does not
decay -o writes the certificate of that, and says so.

\b
Exit status: 0 a rate is proved, 10 inconclusive, 11 a member does not decay,
2 bad input, 130 interrupted before anything was found.
"""

MAX_SLOPE = """Print the largest slope for which a loop is stable.

\b
Examples:
  lure max-slope --num "1 -0.2 -0.1" --den "1 2 1 1"
  lure max-slope --odd --num "2 0.92" --den "1 -0.5 0" --dt 1 --json
  lure max-slope plant.toml --criterion park
  lure max-slope --transfer "s^2/(s^4+0.2*s^3+6*s^2+0.1*s+1)" --limits

\b
H is the block from mu to sigma, and mu = -phi(sigma) with phi(0) = 0 and
every difference quotient of phi in [K1, k].  Without --odd, or odd = true in
the [class] of the system, nothing is assumed of the symmetry of phi, and a
bound for odd phi need not hold.

\b
With --limits it is also said from which slope on no multiplier of Zames and
Falb with a Popov term proves anything (certified; continuous time): whether
loops beyond it are stable, no search for multipliers will tell.
"""
MAX_SLOPE += _BEST_SO_FAR

GAIN = """Print the L2 gain from a disturbance w to an output z.

\b
Examples:
  lure gain plant.toml
  lure gain plant.toml --set class.sector="[0, 0.5]" --json
  lure gain plant.toml -o gain.json && lure verify gain.json

\b
The file has a [class] or a [nonlinearity] for each channel, and a table
[performance]: Bw, Cz, Dzw, Dzmu and Dsigmaw, 0 where they are left out.
Without it w is added to mu, and z is sigma.
  x' = A x + B mu + Bw w,  sigma = C x + D mu + Dsigmaw w,
  z = Cz x + Dzmu mu + Dzw w,  mu = -phi(sigma),  x(0) = 0.
Printed is a number that the gain of no member of the class exceeds, and one
that the gain of some member exceeds, each with a certificate.  Where no bound
is proved -o writes that of the member, and says so.

\b
Exit status: 0 a bound is proved, 10 none is, 11 the gain is infinite,
2 bad input, 130 interrupted before anything was found.
"""

STEADY = """Print whether one steady response attracts all others.

\b
Examples:
  lure steady plant.toml --amplitude 3 --omega 2
  lure steady plant.toml --amplitude 3 --omega 0.1:10:40 --plot curve.svg
  lure steady plant.toml --amplitude 3 --omega 0.1:10:40 --csv curve.csv
  lure steady plant.toml --json                  forcing from the file
  lure steady plant.toml -o rate.json && lure verify rate.json --second

\b
w(t) = constant + amplitude sin(omega t) enters as [performance] says, or is
added to mu.  With slope bounds the circle criterion proves, for every bounded
w, that one bounded solution attracts all others.  Of a [nonlinearity] its
amplitude, the largest |z| over a period, is enclosed: harmonics are balanced,
what they miss is bounded in ball arithmetic, and a certified gain bounds the
error.  Without [performance] z is sigma.  A rod: see lure response --help.

\b
-o writes the certificate of the rate, or of the member whose differences do
not decay.  None stands behind an open answer, nor behind two responses that
are shown to exist in balls; then nothing is written.

\b
Exit status: 0 one solution attracts all, 10 inconclusive, 11 in some loop it
does not, 2 bad input, 130 interrupted before anything was found.
"""

EXPLORE = """Write a page to explore a loop in the browser.

\b
Examples:
  lure explore -o page           then open page/index.html
  lure explore plant.toml        the page opens with your loop
  lure explore kalman-fitts      or with one from the literature

Static files for any web server, or for a browser without a network: change
the block, drag k and theta, and a proof is found and checked in the page, in
exact arithmetic, by both checkers. What the browser needs is fetched once,
through npm and pip, and kept in ~/.cache/lure.
"""

SWEEP = """Answer one question for many systems, as a labelled data set.

\b
Examples:
  lure sweep study.toml -o study.zarr --workers 2
  lure sweep study.toml -o study.zarr --scheduler tcp://127.0.0.1:8786
  lure sweep study.zarr --report

\b
The file names a system, what is varied (keys as for --set) and what is asked:
  system = "paper-rod"       # or a TOML file
  ask = "rod"         # or sector, slope, class, gain, rate, region, or a list
  [over]
  "rod.damping" = { from = 1e-4, to = 1e-2, count = 1000, spacing = "log" }
  "rod.compliance" = [0.1, 1, 10]

\b
In place of a grid points are drawn, always the same ones for one seed:
  [draw]
  count = 1000
  seed = 7
  method = "sobol"           # or "random"
  [over]
  "rod.damping" = { between = [1e-4, 1e-2], spacing = "log" }
  "rod.compliance" = { mean = 1, deviation = 0.1 }

\b
Parameters of a plant may be cut into intervals, each answered as a whole:
  [boxes]
  "plant.parameters.a" = { from = 1, to = 3, count = 10 }

\b
A grid gets more points where the verdict changes with
  refine = "boundary"

\b
After an interruption the same command goes on: what is done is kept. A
point that fails is a row with its sentence in the variable error. One row in
1000, at least one, is computed again and rechecked before the run ends.

\b
Exit status: 0 all points are done, 2 bad input or every point failed,
130 interrupted.
"""

REGION = """Say from which states a loop recovers.

\b
Examples:
  lure region plant.toml
  lure region plant.toml --json
  lure region plant.toml --along "1 1; 1 -1"
  lure region plant.toml -o region.json --plot region.svg

\b
For one known nonlinearity in each channel: sets from which every solution
tends to 0, proved by what holds on the set alone (a sector on an interval,
the limits of a saturation), and sets from which none does.  With one state
and a nonlinearity of polynomials between cuts both sides meet.  A start in
neither may be attracted or not.  In continuous time there is no set where the
loop near 0 is linear and not stable.

\b
Exit status: 0 a set is proved, 10 none was found, 11 there is none,
2 bad input, 130 interrupted.
"""

VERIFY = """Check certificates in exact arithmetic.

\b
Examples:
  lure verify certificate.json
  lure verify lure-report/certificates/*.json
  lure verify certificate.json --second --json
  lure certify third-order --sector 0 5.9 -o - | lure verify -

\b
Prints ACCEPTED, the claim, the loop that it is about, the theorem and every
hypothesis that was checked, or REJECTED and why.  Nothing in a file is
believed: the checker recomputes all from the claim.  It needs Python's
standard library only, and runs alone with the seventeen files beside it:
python checker.py certificate.json
--second asks another checker too, which shares no code with the first.

\b
Exit status: 0 accepted, 11 rejected, 2 no certificate (if none is rejected).
"""

EXPORT = """Write a certificate as a proof for Coq.

\b
Examples:
  lure export certificate.json
  lure export certificate.json -o loop.v && coqc loop.v
  lure certify third-order --sector 0 5.9 -o - | lure export - -o loop.v

\b
The file states a theorem about the plant's own coefficients and proves it by
computation, with Coq's standard library alone.  coqc checks the theorem as
the file states it: compare its plant and class with yours.  The file ends
with what the proof assumes: the axioms of the real numbers.

\b
Exit status: 0 written, 2 no certificate, or one of a kind that has no export.
"""

CERTIFY = """Write the certificate of one class of nonlinearities.

\b
Examples:
  lure certify plant.toml
  lure certify --num "1" --den "1 3 2 0" --sector 0 5.9 -o cert.json
  lure certify --transfer "1/(s+1)^3" --slope 0 7.9 --odd
  lure certify ct-1 --slope 0 4.5 --seconds 60
  lure certify third-order --sector 0 5.9 --method matrix --force
  lure certify paper-rod && lure verify certificate.json

\b
The class is that of the file, or --sector and --slope, in every channel if
there are several.  As an upper bound inf means none at all, and finite means
that there is one, of any size.  Nothing is written unless the checker accepts
it.  What stays open has a code: lure explain CODE.

\b
Exit status: 0 proved, 10 inconclusive, 11 refuted, 2 bad input.
"""

EXPLAIN = """Explain the code of an open answer.

\b
Examples:
  lure explain
  lure explain LURE-I001
  lure explain I013 --json

\b
What happened, what it means and does not mean, and what to try.  Without a
code: the list of all.
"""

COMPARE = """Hold the scheme and Galerkin models against the exact motion.

\b
Examples:
  lure compare paper-rod
  lure compare paper-rod --until 0.01 --plot compare.svg
  lure compare rod.toml --cells 10,20,40,80 --galerkin P1:26,P1:51
  lure compare paper-rod --cells 200 --method CVODE --galerkin none --json
  lure compare paper-rod --set rod.gap=5e-5 --set rod.compliance=1e-9

\b
One table: error of u(t, L), energy, decay of the elastic modes, observed
order, cost; for the release of the paper also its settling time.  The exact
row is about the rod, every other row about a discrete model.

\b
Methods for the scheme: exact (no time step), RK45, DOP853, Radau, BDF, LSODA
(scipy), CVODE, CVODE-Adams (needs lure[cvode]).

\b
Exit status: 0 done, 2 bad input, 1 a bug in lure, 130 interrupted.
"""

SIMULATE = """Follow one motion of a rod, and write or draw it.

\b
Examples:
  lure simulate paper-rod --until 0.01
  lure simulate paper-rod --until 10 --method exact -o run.nc
  lure simulate rod.toml --set rod.gap=5e-5 --plot run.svg
  lure simulate paper-rod --method scheme --cells 200 --plot scheme.png
  lure simulate paper-rod --method galerkin --space P2 --order 101
  lure simulate rod.toml --rigid --animation run.gif --space-time run.png
  lure simulate rod.toml --span 0.678 0.681 --animation run.mp4

\b
Methods:
  exact     the rod itself along its characteristics, to rounding
  scheme    the upwind scheme of --cells N, without error in time
  galerkin  the weak form in --space P1, P2 or cosine of --order m
  LSODA, RK45, DOP853, Radau, BDF, CVODE
            a general integrator on the scheme of --cells N
Only `exact` is a motion of the rod; every result says what moved.
Rods with several contacts, a file with [contact], move exactly, with
--until, --samples, --output and --plot; their data are [[rod]] u0, u1, g.

\b
A file run.nc is netCDF 4 (needs lure[netcdf]); figures are SVG or PNG;
animations GIF, MP4 (needs ffmpeg) or, without a suffix, a folder of PNG.
All appear together when all is done; what exists is kept without --replace.

\b
Exit status: 0 done, 2 bad input, 1 a bug in lure, 130 interrupted.
"""

RESPONSE = """Say what a rod does under a periodic force after a while.

\b
Examples:
  lure response paper-rod --set rod.gap=0 --set rod.damping=0.24 \\
      --set rod.compliance=3.5e-11 --force "0.3+0.7*sin(3000*t)" --settle 0.5
  lure response paper-rod --set rod.gap=0 --set rod.damping=0.24 \\
      --set rod.compliance=3.5e-11 --force "0.3+where(sin(3000*t)>0,1,-1)" \\
      --separation --plot response.svg
  lure response rod.toml --rigid --json > response.json

\b
The motion of the rod itself, exactly: regime, time in contact, impacts,
momentum, spectrum.  The period must follow from the formula (sines and
cosines with commensurable frequencies), or be given with --period.  A force
of mean 0 has no periodic response with contact: the rod walks away.
A motion that was not seen to repeat is not thereby proved chaotic.
A run costs round trips 2L/c: a light dashpot or a soft obstacle takes many.

\b
Exit status: 0 done, 2 bad input, 1 a bug in lure, 130 interrupted (nothing is
written).
"""

BIFURCATION = """Follow the response through the values of a parameter.

\b
Examples:
  lure bifurcation paper-rod --set rod.gap=0 --set rod.damping=0.24 \\
      --set rod.compliance=3.5e-11 --force "0.3+F*sin(3000*t)" \\
      --parameter F --from 0.5 --to 1.1 --count 31 --plot doubling.png
  lure bifurcation rod.toml --set rod.damping=0.24 --rigid \\
      --force "0.3+F*sin(3000*t)" --parameter F --from 0.5 --to 1.1 \\
      --count 31 --settle 0.1 --sweep down --json > down.json
  lure bifurcation rod.toml --force "0.3+0.7*sin(3000*t)" --rigid \\
      --parameter damping --from 0.1 --to 0.5 --count 20 --workers 2

\b
The parameter is a symbol of the force or a field of the rod: damping, gap,
compliance, youngs_modulus, density, length, area, exponent.  Each value
starts from the same data; with --sweep up or down it starts from the end of
the one before (symbols of the force only), which shows hysteresis.

\b
Ctrl-C keeps what is done: it is printed, written and drawn, and says that it
is not all.
Exit status: 0 done, 2 bad input, 1 a bug in lure, 130 interrupted.
"""

BASIN = """Say where a rod without a force comes to rest.

\b
Examples:
  lure basin paper-rod --set rod.gap=0 --set rod.damping=0.24 \\
      --set rod.compliance=3.5e-11 --offset -1e-4 1e-4 9 \\
      --velocity -0.5 1 13 --plot basin.png
  lure basin rod.toml --set rod.damping=0.05 --set rod.compliance=1e-11 \\
      --velocity 0 100 6 --json

\b
Uniform displacements [m] and velocities [m/s] are added to the initial data.
Each motion is followed until it is known where it ends, or bounds are given.
Ctrl-C keeps what is done.

\b
Exit status: 0 done, 10 a resting place is not known, 2 bad input, 1 a bug in
lure, 130 interrupted.
"""

AS_PRINTED = (
    "Note: the scheme as printed answers the force divided by c N/L; the rod here answers the force as it stands."
)

SECTOR = """Bound a nonlinearity: sector or slopes, from both sides.

\b
Examples:
  lure sector --expr "max(x,0)**1.5" --on -1 1
  lure sector --expr "tanh(sigma) + sigma/3" --slope
  lure sector --expr "sin(x)" --within -0.25 1 --plot sector.svg
  lure sector --expr "min(max(2*x,-1),1)" --json
  lure sector data.csv --displacement depth --force load --fit
  lure sector data.csv --area 25e-6 --origin gap --plot data.svg
  lure sector amplifier.csv --units V,V

\b
Of a formula: the least and the largest phi(sigma)/sigma, or slope, over all
of R or the interval, certified: exact for piecewise linear ones, by isolated
roots for polynomials and rational functions, else in ball arithmetic with
zero and infinity included.

\b
Of measured data: bounds on the chords and slopes of the mean nonlinearity
that hold with the confidence, under the assumptions printed; outliers are
named, and loading and unloading compared.  This is observed and proves
nothing.  Units stand in the headings, displacement [um], force (mN), or in
--units mm,lbf.

\b
With --within, a point (or two, for slopes) is printed where the nonlinearity
leaves the bounds.

\b
Exit status: 0 shown, or within the bounds; 11 the bounds are violated at a
point; 10 not decided, or measured data with hysteresis or without a stated
confidence; 2 bad input.
"""
