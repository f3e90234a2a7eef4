"""A headless Chromium, driven through chromedriver's WebDriver protocol with the standard library alone."""
import base64
import json
import re
import shutil
import struct
import subprocess
import tempfile
import urllib.error
import urllib.request
import zlib

ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # the key that marks an element in the protocol


def missing():
    """What the machine lacks to run a browser; nothing when it is all there."""
    return [name for name in ("chromium", "chromedriver") if shutil.which(name) is None]


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
        arguments = ["--headless=new", "--no-sandbox", "--window-size=1280,1600", "--hide-scrollbars", "--use-angle=swiftshader",
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
    """The set of colours of an 8-bit PNG, and how many pixels have the commonest (PNG specification, filters 0 to 4)."""
    at, packed, width, height, channels = 8, b"", 0, 0, 4
    while at < len(png):
        length, kind = struct.unpack(">I4s", png[at:at + 8])
        body = png[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, _, colour_type = struct.unpack(">IIBB", body[:10])
            channels = {2: 3, 6: 4}[colour_type]
        if kind == b"IDAT":
            packed += body
        at += length + 12
    raw, stride, before, counts = zlib.decompress(packed), width * channels, bytearray(width * channels), {}
    for row in range(height):
        begin = row * (stride + 1)
        line = bytearray(raw[begin + 1:begin + 1 + stride])
        unfilter(raw[begin], line, before, channels)
        for i in range(0, stride, channels):
            colour = bytes(line[i:i + 3])
            counts[colour] = counts.get(colour, 0) + 1
        before = line
    return set(counts), max(counts.values()) / (width * height)


def unfilter(kind, line, before, step):
    for i in range(len(line) if kind else 0):
        left, up, corner = line[i - step] if i >= step else 0, before[i], before[i - step] if i >= step else 0
        if kind == 4:
            guess = left + up - corner
            distances = abs(guess - left), abs(guess - up), abs(guess - corner)
            prediction = (left, up, corner)[distances.index(min(distances))]
        else:
            prediction = (left, up, (left + up) // 2)[kind - 1]
        line[i] = (line[i] + prediction) & 255
