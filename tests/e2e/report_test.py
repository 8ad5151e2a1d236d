"""report.html as a reader meets it: whole, self-contained, readable at any width."""
import html
import html.parser
import json
import os
import pathlib
import re
import shutil
import subprocess
import unittest

from fricid_program import ProgramTest, fricid

VOID = {"meta", "link", "input", "br", "img", "hr", "source"}
SECTIONS = ["result", "open-loop", "friction", "models", "warnings", "data", "reproduce"]


class Page(html.parser.HTMLParser):
    """What a page refers to, what it can be referred to by, and whether its elements nest."""

    def __init__(self, text):
        super().__init__()
        self.ids, self.references, self.open, self.text, self.tags = [], [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        for name, value in attributes:
            if name == "id":
                self.ids.append(value)
            if name in ("href", "src", "xlink:href", "poster", "data", "srcset"):
                self.references.append(value)
            if name == "for":
                self.references.append("#" + value)
            if name.startswith("on"):
                raise AssertionError(f"script in {tag}: {name}")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open[-3:]}"
        self.open.pop()

    def handle_data(self, data):
        self.text.append(data)


# Loads PAGE at each of WIDTHS and leaves what it found in the element "found".
PROBE = """<!doctype html><link rel="icon" href="data:,"><pre id="found"></pre><script>
const found = {};
const drawn = picture => {
  const box = picture.getBoundingClientRect();
  if (picture.tagName === "IMG") return picture.complete && picture.naturalWidth > 0;
  if (picture.tagName === "VIDEO") return !picture.error;
  const lines = [...picture.querySelectorAll("path, polyline, polygon, rect, circle, use")];
  return box.width >= 200 && box.height >= 50 && lines.filter(
    line => { const b = line.getBoundingClientRect(); return b.width + b.height > 0; }).length > 5;
};
const look = (page, width) => {
  page.querySelectorAll("details").forEach(details => { details.open = true; });
  const pictures = [...page.querySelectorAll("svg[role=img], img, video")];
  const first = page.querySelector(".scroll");
  const wide = [...page.querySelectorAll("table, svg[role=img], pre, p, dl")].filter(element =>
    element.getBoundingClientRect().right > width + 1 && !element.closest(".scroll, .plot"));
  return {hidden: page.scrollWidth - page.clientWidth, height: page.scrollHeight, pictures: pictures.length,
    undrawn: pictures.filter(picture => !drawn(picture)).map(p => p.outerHTML.slice(0, 120)),
    first_table_hides: first.scrollWidth - first.clientWidth,
    cut: wide.map(element => element.outerHTML.slice(0, 120))};
};
for (const width of WIDTHS) {
  const frame = document.createElement("iframe");
  frame.style.cssText = `width:${width}px;height:900px;border:0`;
  frame.src = PAGE;
  frame.onload = () => {
    found[width] = look(frame.contentDocument.documentElement, width);
    document.getElementById("found").textContent = JSON.stringify(found);
  };
  document.body.append(frame);
}</script>"""


class Report(ProgramTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.label = "l<u>g\"r'e & co"

    def job(self, **options):
        scene = self.tiny(changes={'name = "lugre"\nstarts = 1':
                                   'name = "lugre"\nlabel = %s\nstarts = 1' % json.dumps(self.label)})
        folder = self.folder / "a run"
        done = fricid("run", scene, "-o", folder, **options)
        self.assertIn(done.returncode, (0, 1), done.stderr)  # 1: a horizon cannot rank models
        return folder, done

    def seen_in(self, browser, page, widths):
        """What the probe finds at each width, and the messages of the browser's console."""
        probe = self.write("probe.html", PROBE.replace("PAGE", json.dumps(page.as_uri())).replace(
            "WIDTHS", json.dumps(widths)))
        done = subprocess.run(
            [browser, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr",
             "--allow-file-access-from-files", f"--user-data-dir={self.folder / 'browser'}",
             "--virtual-time-budget=20000", "--dump-dom", probe.as_uri()],
            capture_output=True, text=True, timeout=300, env=os.environ | {"HOME": str(self.folder)})
        found = re.search(r'<pre id="found">(.*?)</pre>', done.stdout, re.DOTALL)
        messages = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
        self.assertTrue(found and found.group(1), (messages, done.stderr[-2000:]))
        return json.loads(html.unescape(found.group(1))), messages

    def check(self, folder):
        text = (folder / "report.html").read_text()
        page = Page(text)
        self.assertEqual(page.open, [])
        self.assertEqual(len(page.ids), len(set(page.ids)), "an id twice")
        self.assertNotIn("script", page.tags)
        self.assertNotRegex(text, r"(?i)https?:|@import|url\(")
        for reference in page.references:
            if reference.startswith("#"):
                self.assertIn(reference[1:], page.ids)
            elif not reference.startswith("data:"):
                self.assertTrue((folder / reference).is_file(), reference)
        return page, text

    def test_is_whole_and_needs_nothing_else(self):
        folder, _ = self.job()
        page, text = self.check(folder)
        for section in SECTIONS:
            self.assertIn(section, page.ids)
        shown = "".join(page.text)
        self.assertIn(self.label, shown)
        self.assertNotIn("<u>", text)
        self.assertIn("of 2 models", shown.lower())
        self.assertNotRegex(shown, r"\bnan\b|\binf\b|null")
        svgs = page.tags.count("svg")
        plots = len(list((folder / "plots").glob("*.svg")))
        self.assertEqual(svgs, plots + 1, "every plot and the symbols")

    def test_reads_well_on_a_desk_and_on_a_phone(self):
        browser = shutil.which("chromium") or shutil.which("chromium-browser")
        if browser is None:
            self.skipTest("needs chromium")
        self.label = "LuGre with a name as long as names become"
        folder, _ = self.job()
        found, messages = self.seen_in(browser, folder / "report.html", [1280, 390])
        self.assertEqual(messages, [])
        for width, page in found.items():
            self.assertEqual(page["hidden"], 0, f"the page scrolls sideways at {width} pixels")
            self.assertGreater(page["height"], 2000)
            self.assertGreater(page["pictures"], 5)
            self.assertEqual(page["undrawn"], [], width)
            self.assertEqual(page["cut"], [], "wider than the screen, in a box that does not scroll")
        self.assertEqual(found["1280"]["first_table_hides"], 0, "Table 1 needs a scrollbar")

    def test_every_figure_is_that_of_the_evaluation(self):
        folder, _ = self.job()
        evaluation = json.loads((folder / "evaluation.json").read_text())
        shown = "".join(Page((folder / "report.html").read_text()).text)
        for summary in evaluation["summary"]:
            if summary["name"] == "simulator":
                continue
            for mse in summary["q_mse_geometric_mean"]:
                digits = f"{mse:.1e}"
                mantissa, exponent = digits.split("e")
                written = (f"{mantissa}\u202f×\u202f10−{-int(exponent)}" if mse < 1e-3
                           else f"{mse:.{max(0, 1 - int(exponent))}f}")
                self.assertIn(written, shown)

    def test_without_gnuplot_the_report_is_made_all_the_same(self):
        folder, done = self.job(environment={"PATH": str(self.folder)})
        self.assertRegex(done.stderr, r"(?m)^plots: gnuplot is missing.*install gnuplot-nox$")
        page, _ = self.check(folder)
        self.assertIn("models", page.ids)
        self.assertIn("holds no plots", "".join(page.text))

    def test_a_killed_gnuplot_costs_its_own_plot(self):
        gnuplot = shutil.which("gnuplot")
        if gnuplot is None:
            self.skipTest("needs gnuplot")
        fake = self.folder / "bin" / "gnuplot"
        fake.parent.mkdir()
        fake.write_text(f'#!/bin/sh\ncase "$*" in *error_time*) kill -9 $$ ;; esac\n'
                        f'exec {gnuplot} "$@"\n')
        fake.chmod(0o700)
        path = f"{fake.parent}:{os.environ['PATH']}"
        folder, done = self.job(environment={"PATH": path})
        self.assertRegex(done.stderr, r"(?m)^plots: .*error_time.gp: gnuplot was killed by signal 9")
        scripts = {file.stem for file in (folder / "plots").glob("*.gp")}
        drawn = {file.stem for file in (folder / "plots").glob("*.pdf")}
        self.assertEqual(scripts - drawn, {"error_time"})
        self.assertIn("presliding", drawn)
        self.check(folder)


if __name__ == "__main__":
    unittest.main()
