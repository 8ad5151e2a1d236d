"""report.html as a reader meets it: whole, self-contained, readable at any width."""
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
        self.assert_reads_well_in_chromium(folder)

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

    def assert_reads_well_in_chromium(self, folder):
        """No console message, nothing broken, no sideways scrolling, at the widths of a phone and a desk."""
        browser = shutil.which("chromium") or shutil.which("chromium-browser")
        if browser is None:
            print("skipped: no chromium to look at the report with")
            return
        probe = """<!doctype html><link rel="icon" href="data:,"><pre id="found"></pre><script>
            const found = {};
            for (const width of [380, 1280]) {
              const frame = document.createElement("iframe");
              frame.style.cssText = `width:${width}px;height:900px;border:0`;
              frame.srcdoc = PAGE;
              frame.onload = () => {
                const page = frame.contentDocument.documentElement;
                found[width] = {scroll: page.scrollWidth, height: page.scrollHeight,
                  empty: [...page.querySelectorAll("svg[role=img]")].filter(
                    s => s.getBoundingClientRect().width < 200 && s.checkVisibility()).length};
                document.getElementById("found").textContent = JSON.stringify(found);
              };
              document.body.append(frame);
            }</script>"""
        text = (folder / "report.html").read_text()
        (folder / "probe.html").write_text(
            probe.replace("PAGE", json.dumps(text).replace("</", "<\\/")))
        done = subprocess.run(
            [browser, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr",
             f"--user-data-dir={self.folder / 'browser'}", "--virtual-time-budget=20000", "--dump-dom",
             (folder / "probe.html").as_uri()],
            capture_output=True, text=True, timeout=300, env=os.environ | {"HOME": str(self.folder)})
        self.assertNotRegex(done.stderr, r"CONSOLE")
        found = json.loads(re.search(r'<pre id="found">(.*?)</pre>', done.stdout).group(1))
        for width in ("380", "1280"):
            self.assertLessEqual(found[width]["scroll"], int(width), found)
            self.assertEqual(found[width]["empty"], 0, found)
            self.assertGreater(found[width]["height"], 2000, found)


if __name__ == "__main__":
    unittest.main()
