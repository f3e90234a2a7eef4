"""A headless Chromium, driven through chromedriver's WebDriver protocol."""
import base64
import importlib.util
import io
import json
import re
import shutil
import subprocess
import tempfile
import urllib.error
import urllib.request

if importlib.util.find_spec("PIL") and importlib.util.find_spec("numpy"):
    import numpy
    import PIL.Image

ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # the key that marks an element in the protocol


def missing():
    """What the machine lacks to run a browser and look at its pictures; nothing when it is all there."""
    return [name for name in ("chromium", "chromedriver") if shutil.which(name) is None] + \
        [f"python3-{name.lower()}" for name in ("numpy", "PIL") if importlib.util.find_spec(name) is None]


class Browser:
    """One window of 1280 x 1600 pixels. Use it in a `with` block."""

    def __enter__(self):
        self._profile = tempfile.TemporaryDirectory(prefix="simgap-browser-")
        self._driver = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        for line in self._driver.stdout:  # "... was started successfully on port 12345."
            port = re.search(r"successfully on port (\d+)", line)
            if port:
                break
        self._base = f"http://127.0.0.1:{port.group(1)}/session"
        arguments = ["--headless=new", "--no-sandbox", "--window-size=1000,900", "--hide-scrollbars", "--use-angle=swiftshader",
                     "--enable-unsafe-swiftshader", "--force-prefers-reduced-motion", f"--user-data-dir={self._profile.name}"]
        answer = self._request("POST", "", {"capabilities": {"alwaysMatch": {
            "browserName": "chrome", "goog:chromeOptions": {"args": arguments, "binary": shutil.which("chromium")},
            "goog:loggingPrefs": {"browser": "ALL"}}}})
        self._base += "/" + answer["sessionId"]
        return self

    def __exit__(self, *error):
        try:
            self._request("DELETE", "")
        finally:
            self._driver.terminate()
            self._driver.wait()
            self._driver.stdout.close()
            self._profile.cleanup()

    def _request(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self._base + path, data, {"Content-Type": "application/json"}, method=method)
        try:
            with urllib.request.urlopen(request, timeout=120) as response:
                return json.load(response)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(json.load(error)["value"]["message"]) from None

    def reset(self):
        """Forgets what a test has told the browser to pretend."""
        self.protocol("Emulation.setEmulatedMedia", features=[])
        self.protocol("Emulation.clearDeviceMetricsOverride")
        self.console()

    def open(self, file):
        self._request("POST", "/url", {"url": file.resolve().as_uri()})

    def run(self, script, *arguments):
        """The value that the body of a JavaScript function returns."""
        return self._request("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def find(self, selector):
        return self._request("POST", "/element", {"using": "css selector", "value": selector})[ELEMENT]

    def click(self, element):
        self._request("POST", f"/element/{element}/click", {})

    def type(self, element, keys):
        self._request("POST", f"/element/{element}/value", {"text": keys})

    def console(self):
        """What the page has complained of since the last call."""
        return [entry["message"] for entry in self._request("POST", "/se/log", {"type": "browser"}) if entry["level"] in ("WARNING", "SEVERE")]

    def protocol(self, command, **parameters):
        """A command of the DevTools protocol."""
        return self._request("POST", "/goog/cdp/execute", {"cmd": command, "params": parameters})

    def screenshot(self, element=None):
        return base64.b64decode(self._request("GET", f"/element/{element}/screenshot" if element else "/screenshot"))

    def whole_page(self):
        size = self.protocol("Page.getLayoutMetrics")["cssContentSize"]
        clip = {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}
        return base64.b64decode(self.protocol("Page.captureScreenshot", format="png", captureBeyondViewport=True, clip=clip)["data"])


def pixels(png):
    """How many colours a picture has, and the share of the commonest."""
    colours = numpy.asarray(PIL.Image.open(io.BytesIO(png)).convert("RGB"), dtype=numpy.uint32) @ numpy.array([65536, 256, 1], numpy.uint32)
    counts = numpy.unique(colours, return_counts=True)[1]
    return len(counts), counts.max() / counts.sum()
