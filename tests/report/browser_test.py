#!/usr/bin/env python3
"""Every command's report.html as a reader sees it: in a real browser, from disk.

    tests/report/browser_test.py SIMGAP SOURCE [--keep DIR]

Runs the commands on small data, opens each page and looks: no complaint in the console, every chart has data and paints
something, the table behind a figure opens, the slider moves the arm, the toggle changes it, dark and light differ, it
prints. Exits with 77 (skipped) where there is no Chromium. --keep leaves the pages and their pictures in DIR.
"""
import argparse
import base64
import functools
import pathlib
import sys
import tempfile
import time
import types
import unittest

import sample_runs
import webdriver

SKIPPED = 77

# What a page is asked: bodies of JavaScript functions.
FOREIGN = "return performance.getEntriesByType('resource').map(r => r.name).filter(name => !name.startsWith('data:'))"
ANSWER = "return document.querySelector('.answer').textContent.trim()"
VIEWS = "return document.querySelectorAll('.scene').length"
PICTURES = "return [...document.images].reduce((sum, image) => sum + image.src.length, 0)"
VERDICT = "const box = document.querySelector('.verdict'); return box && [box.className, box.querySelector('strong').textContent, box.querySelector('code')?.textContent || '']"
NAMELESS = """
  const named = e => e.getAttribute('aria-label') || e.textContent.trim() || e.labels?.length;
  return [...document.querySelectorAll('canvas, button, input, summary, [role=region]')].filter(e => !named(e)).map(e => e.outerHTML.slice(0, 80))"""
UNFOLD = "document.querySelectorAll('details.section').forEach(section => { section.wasOpen = section.open; section.open = true; })"
FOLD = "document.querySelectorAll('details.section').forEach(section => { section.open = section.wasOpen; })"
CHARTS = """
  return [...document.querySelectorAll('figure.chart')].map((figure, i) => {
    const canvas = figure.querySelector('canvas');
    const bytes = canvas.width && canvas.height ? canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data : [];
    const colours = new Set();  // three are enough
    for (let k = 0; k < bytes.length && colours.size < 3; k += 4) if (bytes[k + 3] > 200) colours.add(bytes[k] << 16 | bytes[k + 1] << 8 | bytes[k + 2]);
    const finite = value => Array.isArray(value) ? value.some(finite) : typeof value === 'object' && value ? isFinite(value.y) && value.y !== null : typeof value === 'number' && isFinite(value);
    const numbers = charts[i].data.datasets.flatMap(d => d.data).filter(finite).length;
    return {caption: figure.querySelector('figcaption').textContent, numbers, colours: colours.size, label: canvas.getAttribute('aria-label')};
  });"""
NUMBERS = """
  document.querySelectorAll('.numbers').forEach(details => { details.open = true; details.dispatchEvent(new Event('toggle')); });
  return [...document.querySelectorAll('.numbers')].map(details => details.querySelectorAll('tbody tr').length);"""


class Pages(unittest.TestCase):
    simgap = source = folder = None
    keep = False  # pictures, too

    @classmethod
    def setUpClass(cls):
        cls.names = sample_runs.make(cls.simgap, cls.source, cls.folder)
        cls.browser = cls.enterClassContext(webdriver.Browser())

    def setUp(self):
        self.browser.reset()

    @classmethod
    def file(cls, name):
        return cls.folder / name / "report.html"

    def open(self, name):
        self.browser.open(self.file(name))

    @classmethod
    def picture(cls, name, png):
        (cls.folder / f"{name}.png").write_bytes(png)

    @classmethod
    @functools.cache  # to open a page takes longest
    def seen(cls, name):
        """A page as it opens, then with all sections unfolded, then with all numbers shown, then on a telephone."""
        cls.browser.open(cls.file(name))
        ask = cls.browser.run
        page = types.SimpleNamespace(
            complaints=cls.browser.console(), foreign=ask(FOREIGN), answer=ask(ANSWER), views=ask(VIEWS), pictures=ask(PICTURES),
            verdict=ask(VERDICT), copies=ask("return document.querySelectorAll('.verdict .copy').length"), nameless=ask(NAMELESS),
            language=ask("return document.documentElement.lang"), titles=ask("return document.querySelectorAll('h1').length"),
            images=ask("return [...document.querySelectorAll('.image img')].map(i => i.complete && i.naturalWidth > 100)"))
        if cls.keep:
            cls.picture(name, cls.browser.whole_page())
        page.colours, page.commonest = webdriver.pixels(cls.browser.screenshot())
        ask(UNFOLD)
        page.charts = cls.painted()
        ask(FOLD)
        page.rows, page.complaints_of_numbers = ask(NUMBERS), cls.browser.console()
        page.telephone = cls.narrow(name)
        return page

    @classmethod
    def painted(cls):
        """The charts, as soon as all have painted something: what was folded has to find its size."""
        end = time.monotonic() + 10.0
        while True:
            charts = cls.browser.run(CHARTS)
            if all(chart["colours"] > 2 for chart in charts) or time.monotonic() > end:
                return charts
            time.sleep(0.05)

    @classmethod
    def narrow(cls, name):
        """The width that the open page takes on a telephone, and the labels and muscles of its intervals where it has them."""
        cls.browser.protocol("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=1, mobile=True)
        end = time.monotonic() + 10.0
        while (width := cls.browser.run("return document.documentElement.scrollWidth")) > 390 and time.monotonic() < end:
            time.sleep(0.05)  # charts find their size
        if cls.keep:
            cls.picture(f"{name}-narrow", cls.browser.screenshot())
        labels = """
          const chart = charts[page.charts.findIndex(spec => spec.kind === 'intervals')];
          return chart && chart.scales.y.ticks.map(tick => tick.label)"""
        telephone = types.SimpleNamespace(width=width, labels=cls.browser.run(labels),
                                          muscles=cls.browser.run("return typeof views === 'undefined' ? null : views[0].data.muscles"))
        cls.browser.reset()
        return telephone

    def test_every_page_opens_from_disk_without_complaint(self):
        for name in self.names:
            with self.subTest(name):
                page = self.seen(name)
                self.assertEqual(page.complaints, [])
                self.assertEqual(page.foreign, [])
                self.assertTrue(page.answer)
                self.assertLess(self.file(name).stat().st_size - page.pictures, 1_500_000 if page.views else 400_000)
                self.assertGreater(page.colours, 50)
                self.assertLess(page.commonest, 0.99)

    def test_every_chart_has_data_and_paints(self):
        for name in self.names:
            charts = self.seen(name).charts
            self.assertTrue(charts, name)
            for chart in charts:
                with self.subTest(page=name, chart=chart["caption"]):
                    self.assertGreater(chart["numbers"], 0)
                    self.assertGreater(chart["colours"], 2, "axes alone, or nothing")
                    self.assertTrue(chart["label"])

    def test_the_numbers_stand_behind_every_figure(self):
        for name in self.names:
            with self.subTest(name):
                page = self.seen(name)
                self.assertTrue(page.rows and all(count > 0 for count in page.rows), page.rows)
                self.assertEqual(page.complaints_of_numbers, [])

    def test_the_slider_moves_the_arm(self):
        for name in ("calibrate", "validate", "capture"):
            with self.subTest(name):
                self.open(name)
                view, slider = self.browser.find(".view canvas"), self.browser.find("input[type=range]")
                said = "return document.querySelector('.said').textContent"
                first, first_said = self.browser.screenshot(view), self.browser.run(said)
                colours, commonest = webdriver.pixels(first)
                self.assertGreater(colours, 50)
                self.assertLess(commonest, 0.999, "an empty view")
                self.browser.type(slider, "\ue014" * 3)  # arrow right: it can be used without a mouse
                self.assertEqual(self.browser.run("return views[0].pose"), 3)
                self.assertNotEqual(self.browser.screenshot(view), first)
                self.assertNotEqual(self.browser.run(said), first_said)
                self.assertEqual(self.browser.console(), [])

    def test_every_page_says_what_it_is_worth(self):
        for name in self.names:
            with self.subTest(name):
                kind, words, command = self.seen(name).verdict
                self.assertIn(kind.split()[1], ("good", "doubtful", "bad"))
                self.assertTrue(words)
                self.assertTrue(not command or command.startswith("simgap "), command)
        self.assertEqual(self.seen("calibrate").copies, 1)

    def test_long_logs_can_be_looked_into(self):
        for name in ("diagnose", "fit-friction", "fit-motor", "capture"):
            with self.subTest(name):
                self.open(name)
                index = self.browser.run("return page.charts.findIndex(spec => spec.zoom)")
                self.assertGreaterEqual(index, 0)
                span = f"const x = charts[{index}].scales.x; return x.max - x.min"
                whole = self.browser.run(span)
                drag = """
                  const canvas = charts[arguments[0]].canvas, box = canvas.getBoundingClientRect(), area = charts[arguments[0]].chartArea;
                  const at = (share, type) => canvas.dispatchEvent(new PointerEvent(type, {bubbles: true, clientX: box.left + area.left + share * (area.right - area.left), clientY: box.top + 50}));
                  at(0.25, 'pointerdown'); at(0.5, 'pointermove'); at(0.5, 'pointerup');"""
                self.browser.run(drag, index)
                quarter = self.browser.run(span)
                self.assertAlmostEqual(quarter / whole, 0.25, delta=0.02)
                self.browser.run("""
                  const canvas = charts[arguments[0]].canvas, box = canvas.getBoundingClientRect(); canvas.focus();
                  canvas.dispatchEvent(new WheelEvent('wheel', {bubbles: true, cancelable: true, deltaY: -300, clientX: box.left + box.width / 2, clientY: box.top + 50}));""", index)
                self.assertLess(self.browser.run(span), 0.9 * quarter)
                spans = self.browser.run("return charts.filter(c => c.config.options.zoom).map(c => c.scales.x.max - c.scales.x.min)")
                self.assertLess(max(spans) - min(spans), 1e-6 * max(spans), "all of a group show the same stretch")
                self.browser.run("document.querySelector('.zoom button').click()")
                self.assertAlmostEqual(self.browser.run(span), whole, delta=1e-6 * whole)
                self.assertEqual(self.browser.console(), [])

    def test_a_click_on_a_bar_shows_that_pose(self):
        for name in ("calibrate", "validate", "diagnose-poses"):
            with self.subTest(name):
                self.open(name)
                label = self.browser.run("""
                  const index = page.charts.findIndex(spec => spec.poses), chart = charts[index];
                  chart.options.onClick({}, [{index: 2}]);
                  return `${page.charts[index].poses} pose ${page.charts[index].labels[2]}`;""")
                self.assertEqual(self.browser.run("return views[0].data.poses[views[0].pose].name"), label)

    def test_the_arm_names_its_parts(self):
        for name in ("validate", "design", "diagnose-poses"):
            with self.subTest(name):
                self.open(name)
                names = self.browser.run("""
                  const found = new Set();
                  const canvas = views[0].renderer.domElement, box = canvas.getBoundingClientRect();
                  for (let i = 1; i < 40; ++i) for (let j = 1; j < 30; ++j) {
                    canvas.dispatchEvent(new PointerEvent('pointermove', {clientX: box.left + box.width * i / 40, clientY: box.top + box.height * j / 30}));
                    if (!views[0].pointed.hidden) found.add(views[0].pointed.textContent.split(',')[0]);
                  }
                  return [...found];""")
                self.assertTrue({"torso", "humerus", "forearm"} & set(names), names)
                self.assertIn("torso", names)
                self.assertTrue(set(names) & set(self.browser.run("return views[0].data.muscles")), names)

    def test_the_overlay_of_a_capture_is_in_its_page(self):
        self.assertEqual(self.seen("capture").images, [True])

    def test_labels_of_a_telephone_keep_the_muscle(self):
        page = self.seen("calibrate").telephone
        for label in page.labels:
            self.assertTrue(any(label.startswith(muscle) for muscle in page.muscles), label)
            self.assertLess(len(label), 40)

    def test_the_toggle_shows_before_and_after(self):
        self.open("calibrate")
        view = self.browser.find(".view canvas")
        pressed = "return [...document.querySelectorAll('.controls button')].filter(b => b.getAttribute('aria-pressed') === 'true').map(b => b.textContent)"
        after = self.browser.screenshot(view)
        self.assertEqual(self.browser.run(pressed), ["after", "measured as a ghost"])
        before_button, ghost_button = (self.browser.run(
            "return [...document.querySelectorAll('.controls button')].find(b => b.textContent.startsWith(arguments[0]))", text)[webdriver.ELEMENT]
            for text in ("before", "measured"))
        self.browser.click(before_button)
        before = self.browser.screenshot(view)
        self.assertNotEqual(before, after)
        self.assertEqual(self.browser.run(pressed), ["before", "measured as a ghost"])
        self.browser.click(ghost_button)
        self.assertNotEqual(self.browser.screenshot(view), before)
        self.assertEqual(self.browser.run(pressed), ["before"])

    def test_the_arm_turns_by_keys_and_buttons(self):
        self.open("validate")
        view = self.browser.find(".view canvas")
        pictures = {self.browser.screenshot(view)}
        self.browser.type(view, "\ue012\ue012")  # arrow left
        pictures.add(self.browser.screenshot(view))
        for text in ("front", "side", "top"):
            self.browser.run("[...document.querySelectorAll('.controls button')].find(b => b.textContent === arguments[0]).click()", text)
            pictures.add(self.browser.screenshot(view))
        self.assertEqual(len(pictures), 5)

    def test_bodies_stand_where_the_tables_say(self):
        self.open("validate")
        shown = self.browser.run("""
          const pose = views[0].data.poses[views[0].pose], forearm = views[0].data.bodies.indexOf('forearm');
          const frame = views[0].content.children[forearm];
          return {name: pose.name, at: frame.position.toArray(), count: frame.children.length};""")
        rows = [line.split(",") for line in (self.folder / "validate/arm_bodies.csv").read_text().splitlines()]
        row = next(r for r in rows if f"{r[0]} pose {r[1]}" == shown["name"] and r[2] == "simulated" and r[3] == "forearm")
        for found, expected in zip(shown["at"], row[4:7]):
            self.assertAlmostEqual(found, float(expected), delta=1e-4)
        self.assertGreater(shown["count"], 0)

    def test_dark_and_light_and_paper(self):
        background = "return getComputedStyle(document.body).backgroundColor"
        for name in ("calibrate", "fit-friction"):
            with self.subTest(name):
                found = {}
                for scheme in ("light", "dark"):
                    self.browser.protocol("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
                    self.open(name)
                    found[scheme] = self.browser.run(background)
                    if self.keep:
                        self.picture(f"{name}-{scheme}", self.browser.whole_page())
                self.assertEqual(found["light"], "rgb(255, 255, 255)")
                self.assertNotEqual(found["dark"], found["light"])
                self.assertEqual(self.browser.console(), [])
                self.browser.run("dispatchEvent(new Event('beforeprint'))")
                self.assertEqual(self.browser.run(background), "rgb(255, 255, 255)", "dark pages are printed on white paper")
                self.browser.run("dispatchEvent(new Event('afterprint'))")
                self.assertEqual(self.browser.run(background), found["dark"])
                pdf = base64.b64decode(self.browser.protocol("Page.printToPDF", printBackground=True)["data"])
                (self.folder / f"{name}.pdf").write_bytes(pdf)
                self.assertEqual(pdf[:4], b"%PDF")
                self.assertEqual(self.browser.console(), [])

    def test_everything_can_be_named_by_a_screen_reader(self):
        for name in self.names:
            with self.subTest(name):
                page = self.seen(name)
                self.assertEqual(page.nameless, [])
                self.assertEqual(page.language, "en")
                self.assertEqual(page.titles, 1)

    def test_nothing_is_wider_than_a_telephone(self):
        for name in self.names:
            with self.subTest(name):
                self.assertLessEqual(self.seen(name).telephone.width, 390)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("simgap", type=pathlib.Path)
    parser.add_argument("source", type=pathlib.Path)
    parser.add_argument("--keep", type=pathlib.Path)
    arguments, others = parser.parse_known_args()
    if webdriver.missing():
        print(f"skipped: {' and '.join(webdriver.missing())} not found (scripts/install_dependencies installs them)")
        return SKIPPED
    Pages.simgap, Pages.source = arguments.simgap.resolve(), arguments.source.resolve()
    with tempfile.TemporaryDirectory(prefix="simgap-pages-") as temporary:
        Pages.folder, Pages.keep = (arguments.keep or pathlib.Path(temporary)).resolve(), bool(arguments.keep)
        return 0 if unittest.main(argv=[sys.argv[0], *others], exit=False, verbosity=2).result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
