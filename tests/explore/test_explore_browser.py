"""The page in Chromium, without a network: it says what the command says, and nothing goes wrong on the way."""

import io
import json
import shutil
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest
from depth import sampled
from explored import LOOPS

from lure.analysis import max_sector
from lure.analysis.certificates.checker import check
from lure.analysis.explore import write_page
from lure.analysis.explore.runtime import content
from lure.errors import InputError

pytestmark = pytest.mark.browser
TOLD = """
async ([hash]) => {
  location.hash = hash;
  await new Promise((done) => setTimeout(done, 0));
  while (document.body.dataset.state !== "done") await new Promise((done) => setTimeout(done, 5));
  const text = (id) => document.getElementById(id).textContent;
  const link = document.getElementById("get-report");
  const report = !link.href ? null : await (await fetch(link.href)).json();
  const { value: k } = document.getElementById("k");
  return { verdict: text("verdict"), reach: text("reach"), refuted: text("refuted"), report, k };
}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    try:
        return write_page(tmp_path_factory.mktemp("explore") / "page").parent
    except InputError as refusal:
        pytest.skip(str(refusal))


@pytest.fixture(scope="module")
def browser():
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("there is no chromium on the path")
    driver = pytest.importorskip(
        "playwright.sync_api", reason="playwright is not installed: pip install 'lure[browser]'"
    )
    with driver.sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield opened
        opened.close()


def opened(browser, address, **options):
    """A page without a network, and what its console said."""
    context = browser.new_context(offline=True, **options)
    page, said = context.new_page(), []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(address)
    page.wait_for_selector("body[data-state=done]", timeout=120_000)
    return page, said


@pytest.fixture(scope="module")
def page(browser, folder):
    page, said = opened(browser, f"{folder.as_uri()}/index.html")
    yield page
    assert said == []


def told(page, address):
    return page.evaluate(TOLD, [address])


def test_the_page_says_what_the_command_says(page):
    for num, den in LOOPS[: sampled(20, of=len(LOOPS))]:
        found = max_sector((num.split(), den.split()))
        says = told(page, f"#num={num.replace(' ', ',')}&den={den.replace(' ', ',')}")
        assert says["reach"] == (found.proved_text or "nothing is proved")
        refuted = "every k" if found.refuted_at == 0 else found.refuted_text or "nothing is refuted"
        assert says["refuted"] == refuted
        assert says["report"]["largest"] == json.loads(json.dumps(found.to_dict()))


def test_a_link_is_a_loop(page):
    says = told(page, "#num=1&den=1,3,2,0&k=5")
    assert (says["k"], says["reach"]) == ("5", "5.999999999")
    assert says["verdict"].startswith("PROVED")
    assert told(page, "#num=1&den=1,3,2,0&k=7")["verdict"].startswith("REFUTED")
    page.wait_for_function("location.hash === '#num=1&den=1,3,2,0&k=7&theta=1.5'")
    assert told(page, "#transfer=1/(s*(s+1)*(s+2))&class=time-varying&k=4/3")["reach"] == "1.333333"


def test_what_a_browser_cannot_look_for_is_said(page):
    # the command proves 1.086956 by Zames-Falb multipliers, which are searched for with numpy
    assert told(page, "#system=dt-6&class=odd")["reach"] == "0.6849315"
    assert page.inner_text("#note").endswith(
        "were left out. They are made by the command lure max-slope --system dt-6 --odd"
    )
    says = told(page, "#num=1&den=1,2,2,1&class=time-varying&k=2.4")  # of packages the note speaks, not the verdict
    assert says["verdict"] == "INCONCLUSIVENothing is decided for phi, time-varying, in the sector [0, 2.4]."


# 1/(s (s + 1)(s + 2)) at k = 5: Popov proves it, and Re H comes down to -3/4 < -1/5 at low frequencies; the block
# 4/((s - 1)(s/3 + 1)) is stable from the gain 1/4 on; biproper, (s^2 - s + 10)/(s^2 + s + 25), has a direct term, which
# asks more of phi
def test_what_a_newcomer_would_stumble_over_is_explained(page):
    told(page, "#num=1&den=1,3,2,0&k=5&theta=1.5")
    assert page.inner_text("#nyquist-caption").endswith("The class is proved all the same, by the criterion popov.")
    told(page, "#transfer=4/((s-1)*(s/3+1))&k=1")
    assert "give a lower gain in (0.25, inf), under Lower end k₁." in page.inner_text("#note")
    told(page, "#transfer=4/((s-1)*(s/3+1))&lower=1/2&k=1")
    assert page.inner_text("#note") == ""
    told(page, "#system=biproper&k=0.8")
    assert "is increasing with a locally Lipschitz inverse" in page.inner_text("#note")


def test_a_slider_moves_the_line_at_once_and_the_verdict_after_it(page):
    told(page, "#num=1&den=1,3,2,0&k=5&theta=1.5")
    assert "accepted" in page.get_attribute("#popov", "class")
    before = page.get_attribute("#popov .forbidden", "d")
    moved = page.evaluate(
        """() => { const one = document.getElementById("k-slider"); one.value = 990;
        one.dispatchEvent(new Event("input"));
        return document.querySelector("#popov .forbidden").getAttribute("d"); }"""
    )
    assert moved != before
    page.wait_for_selector("body[data-state=done]")
    assert "crossed" in page.get_attribute("#popov", "class")
    assert page.inner_text("#verdict").startswith("REFUTED")
    page.click("#best")
    page.wait_for_selector("body[data-state=done]")
    assert page.input_value("#k") == "5.999999999"
    assert "accepted" in page.get_attribute("#popov", "class")
    assert "PROVED" in page.inner_text("#verdict")


def test_the_address_follows_a_drag_a_few_times_a_second(page):
    told(page, "#num=1&den=1,3,2,0&k=5")
    changes = page.evaluate(
        """async () => { let count = 0; const own = history.replaceState.bind(history);
        history.replaceState = (...given) => { count++; own(...given); };
        const k = document.getElementById("k-slider"), began = performance.now();
        for (let i = 0; i < 60; i++) { k.value = 500 + i; k.dispatchEvent(new Event("input")); }
        const took = performance.now() - began;
        await new Promise((done) => setTimeout(done, 400));
        history.replaceState = own;
        return [count, took]; }"""
    )
    assert 1 <= changes[0] <= 3 + changes[1] / 200  # browsers refuse 200 changes in half a minute
    page.wait_for_selector("body[data-state=done]")
    assert f"&k={page.input_value('#k')}&" in page.evaluate("location.hash")


def test_a_drag_before_the_plant_has_arrived_is_about_the_new_plant(page):
    told(page, "#num=1&den=1,3,2,0&k=5")
    curve = page.get_attribute("#popov .curve", "d")
    page.evaluate(
        """() => { const [den, k] = ["den", "k-slider"].map((id) => document.getElementById(id));
        den.value = "1 4 2 1"; den.dispatchEvent(new Event("change"));
        k.value = 100; k.dispatchEvent(new Event("input")); }"""
    )
    page.wait_for_selector("body[data-state=done]")
    assert page.inner_text("#formula") == "Read as H(s) = 1 / (s³ + 4 s² + 2 s + 1)"
    assert page.get_attribute("#popov .curve", "d") != curve
    assert page.inner_text("#reach") == max_sector(([1], [1, 4, 2, 1])).proved_text


def test_what_the_page_hands_out_is_checked_again_outside(page, tmp_path):
    told(page, "#num=1&den=1,3,2,0&k=5&theta=1.4")
    with page.expect_download() as download:
        page.click("#get-certificate")
    certificate = json.loads(Path(download.value.path()).read_text("ascii"))
    assert certificate["multiplier"] == {"theta": "7/5"}
    assert check(certificate).certificate["laws"]["sector"] == ["0", "5"]
    with page.expect_download() as download:
        page.click("#get-popov")
    assert Path(download.value.path()).read_text("utf-8").startswith("<svg")


def test_bad_input_stands_beside_its_field(page):
    says = told(page, "#num=1&den=1,3,x&k=5")
    assert "den[2] is 'x'" in page.inner_text("#den-error")
    assert page.get_attribute("#den", "aria-invalid") == "true"
    assert "PROVED" not in says["verdict"]
    assert (says["reach"], says["refuted"]) == ("–", "–")  # no number of another loop stays
    told(page, "#num=1&den=1,3,2,0&k=5")
    assert page.inner_text("#den-error") == ""


def test_a_refusal_leaves_no_statement_about_the_older_question(page):
    told(page, "#num=1&den=1,3,2,0&k=7")
    assert page.is_visible("#wave-figure")
    for wrong in ("#num=1&den=1,3,2,0&k=5&theta=abc", "#num=1&den=1,3,2,0&k=-1", "#num=1&den=0&k=5"):
        told(page, wrong)
        assert page.inner_text("#popov-caption") == page.inner_text("#nyquist-caption") == ""
        assert page.get_attribute("#popov", "aria-label") == "Popov plot"
        assert page.inner_text("#checkers") == "–"
    assert not page.is_visible("#wave-figure")
    told(page, "#num=1&den=1,3,2,0&k=5&theta=1.5")
    assert "Both checkers accept" in page.inner_text("#popov-caption")
    page.fill("#theta", "")
    page.wait_for_selector("body[data-state=done]")
    assert page.get_attribute("#theta", "aria-invalid") == "true"


def test_a_refusal_leaves_nothing_to_keep(page):
    told(page, "#num=1&den=1,3,2,0&k=7")
    kept = ["get-certificate", "get-refutation", "get-report", "get-toml", "get-popov", "get-nyquist"]
    shown = lambda: [one for one in kept if page.is_visible(f"#{one}")]
    assert shown() == kept
    for wrong in ("#num=1&den=1,3,x&k=7", "#num=1&den=1,3,2,0&k=-1"):
        told(page, wrong)
        assert shown() in ([], ["get-refutation"])  # that of the largest sector does not depend on k
    told(page, "#system=dt-6&k=0.5")
    assert page.is_visible("#get-nyquist")
    assert not page.is_visible("#get-popov")  # in discrete time there is no Popov plot


def test_what_is_typed_is_asked_and_the_old_verdict_marked_before_the_field_is_left(page):
    told(page, "#num=1&den=1,3,2,0&k=5&theta=1.5")
    page.fill("#den", "1 4 2 1")  # an input event and no change event
    assert "old" in page.get_attribute("#verdict", "class")
    assert page.get_attribute("#get-certificate", "href") is None
    page.wait_for_selector("body[data-state=done]")
    assert page.inner_text("#reach") == max_sector(([1], [1, 4, 2, 1])).proved_text
    told(page, "#num=1&den=1,3,2,0&k=5&theta=1.5")  # the field has the focus, and shows the new plant nevertheless
    assert page.evaluate("document.activeElement.id") == "den"
    assert page.input_value("#den") == "1,3,2,0"


def test_a_proof_by_another_multiplier_is_not_said_to_be_one_by_a_line(page):
    told(page, "#num=1.57,-1.0,-0.15&den=1.0,6.434,16.907,25.875,19.258&class=odd&lower=0.1&k=24")
    assert "the criterion park does, whose multiplier, 1 + theta s - tau s^2, is no line" in page.inner_text("#note")
    assert page.input_value("#theta") == "0"


def test_the_k_that_the_page_chooses_is_above_the_lower_end(page):
    # H = 1/(s (s + 1)(s + 2)) with the gain -0.1 has a pole on the right: all is refuted from the lower end on
    says = told(page, "#num=1&den=1,3,2,0&lower=-0.1")
    assert float(says["k"]) > -0.1
    assert says["verdict"].startswith("REFUTED")
    says = told(page, "#num=1&den=1,1&lower=100000")
    assert float(says["k"]) > 100000
    assert page.inner_text("#k-error") == ""


def typed(page, field, text):
    page.fill(field, text)
    page.wait_for_selector("body[data-state=done]")


def test_the_plant_is_shown_as_it_was_read(page):
    told(page, "#num=1&den=1,3,2,0&k=5")
    assert page.inner_text("#dropped") == ""
    typed(page, "#den", "0,2,3,1")  # 1 + 3 s + 2 s^2 + 0 s^3 in ascending order
    assert page.inner_text("#formula") == "Read as H(s) = 0.5 / (s² + 1.5 s + 0.5)"
    assert page.inner_text("#dropped").startswith("Leading zeros of the denominator were left out")
    told(page, "#system=third-order")
    assert page.inner_text("#formula").startswith("H(s) = 1 / (s³")
    assert page.inner_text("#dropped") == ""


def test_a_k_that_was_given_stays_when_the_plant_changes_and_one_that_the_page_took_does_not(page):
    told(page, "#num=1&den=1,3,2,0")
    assert page.input_value("#k") == "4.8"  # four fifths of what is proved
    typed(page, "#den", "1,3,3,1")  # proved up to 8
    assert page.input_value("#k") == "6.4"
    typed(page, "#k", "59.99999999")
    assert page.inner_text("#bar-k") == "59.99999999"  # and not 60
    assert page.get_attribute("#bar", "aria-label").startswith("Proved up to 7.99999")
    typed(page, "#den", "1,4,2,1")
    assert page.input_value("#k") == "59.99999999"
    page.evaluate("for (const one of document.querySelectorAll('form details')) one.open = true")
    typed(page, "#dt", "0.1")
    assert page.input_value("#k") == "59.99999999"
    assert not page.is_visible("#theta")  # in discrete time there is no line
    typed(page, "#lower", "100")
    assert float(page.input_value("#k")) > 100
    page.evaluate("for (const one of document.querySelectorAll('form details')) one.open = false")


def test_the_menu_of_classes_names_nonlinearities(page):
    told(page, "#num=1&den=1,3,2,1&k=5&class=odd")
    assert "saturation" in page.inner_text("#class option:checked")
    assert "Saturation, dead zone, tanh: k₁ = 0, k the slope where it is steepest" in page.inner_text("#class-about")
    assert page.inner_text("#k-label") == "Greatest slope"
    assert page.get_attribute("#class", "aria-describedby").startswith("class-about")


def test_every_field_and_every_drawing_has_a_name_for_a_screen_reader(page):
    told(page, "#num=1&den=1,3,2,0&k=7")
    nameless = page.evaluate(
        """() => [...document.querySelectorAll("input, select, button, svg[role=img]")].filter((one) => {
        const by = document.getElementById(one.getAttribute("aria-labelledby"));
        const names = [one.getAttribute("aria-label"), by?.textContent, one.labels?.[0]?.textContent, one.textContent];
        return !names.some((name) => name?.trim());
        }).map((one) => one.id)"""
    )
    assert nameless == []


def test_keys_are_enough(page):
    told(page, "#num=1&den=1,3,2,0&k=5")
    page.focus("#k-slider")
    page.keyboard.press("ArrowRight")
    page.wait_for_selector("body[data-state=done]")
    assert page.input_value("#k") != "5"
    page.focus("#num")
    reached = []
    for _ in range(10):
        page.keyboard.press("Tab")
        reached.append(page.evaluate("document.activeElement.id"))
    assert [one for one in reached if one][:7] == ["den", "class", "k", "k-slider", "theta", "theta-slider", "best"]


@pytest.mark.parametrize("width", [390, 1280])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_runs_out_of_the_page(browser, folder, width, scheme):
    page, said = opened(
        browser, f"{folder.as_uri()}/index.html", viewport={"width": width, "height": 800}, color_scheme=scheme
    )
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.is_visible("#brief") == (width == 390)  # on a phone the verdict is in sight before its card is
    verdict, k = page.get_attribute("#verdict", "data-verdict"), page.input_value("#k")
    assert page.text_content("#brief") == f"{verdict}, k = {k}"
    page.locator("#rod").scroll_into_view_if_needed()  # whose verdicts are others
    page.wait_for_selector("#brief", state="hidden")
    assert said == []
    page.context.close()


def test_a_static_server_is_enough(browser, folder):
    server = subprocess.Popen(
        [sys.executable, "-m", "http.server", "0", "--bind", "127.0.0.1", "--directory", str(folder)],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={"PYTHONUNBUFFERED": "1"},
        text=True,
    )
    try:
        port = server.stdout.readline().split(" port ")[1].split()[0]
        context = browser.new_context()
        page, asked = context.new_page(), []
        page.on("request", lambda request: asked.append(request.url))
        for visit in ("first", "warm"):
            began = time.monotonic()
            page.goto(f"http://127.0.0.1:{port}/index.html")
            page.wait_for_selector("body[data-state=done]", timeout=120_000)
            print(f"{visit} load to a checked verdict: {time.monotonic() - began:.1f} s")
        assert page.inner_text("#reach") == "5.999999999"
        outside = [one for one in asked if not one.startswith((f"http://127.0.0.1:{port}/", "blob:", "data:"))]
        assert outside == []
    finally:
        server.terminate()
        server.communicate()


def test_a_link_shares_a_rod(browser, folder):
    page, said = opened(browser, f"{folder.as_uri()}/index.html#num=1&den=1,2,1&k=3&damping=Z/3&cells=7&tehta=1")
    assert "The address has tehta, which no field" in page.inner_text("#unread")
    page.wait_for_selector("#scheme-verdict[data-verdict=PROVED]", timeout=60_000)
    assert (page.input_value("#damping"), page.input_value("#cells"), page.input_value("#den")) == ("Z/3", "7", "1,2,1")
    page.fill("#cells", "8")
    page.wait_for_function("location.hash.endsWith('&damping=Z/3&cells=8')")
    page.fill("#k", "2")  # a change of the loop leaves the rod in the address
    page.wait_for_function("location.hash.startsWith('#num=1&den=1,2,1&k=2&')")
    assert page.evaluate("location.hash").endswith("&damping=Z/3&cells=8")
    page.evaluate("location.hash = '#num=1&den=1,2,1&k=3'")
    page.wait_for_selector("#rod:not([open])")
    assert said == []
    page.context.close()


def test_the_package_comes_as_bytecode_where_node_can_make_it(folder):
    if shutil.which("node") is None:
        pytest.skip("there is no node on the path")
    for name, module in (("core", "lure/analysis/certificates/checker.pyc"), ("python_stdlib", "fractions.pyc")):
        packed = content((folder / f"assets/{name}.zip.js").read_text("ascii"))
        assert module in zipfile.ZipFile(io.BytesIO(packed)).namelist()


def test_the_rod_and_its_scheme_have_their_verdicts(page):
    page.click("#rod summary")
    page.wait_for_selector("#scheme-verdict[data-verdict=PROVED]", timeout=60_000)
    assert "Both checkers accept it." in page.inner_text("#rod-verdict")
    page.fill("#damping", "-0.1")
    page.wait_for_selector("#rod-verdict[data-verdict=REFUTED]", timeout=60_000)
    page.fill("#cells", "0")
    page.wait_for_function("document.getElementById('cells-error').textContent.includes('whole number')")
