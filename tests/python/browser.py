"""What a reader's browser finds wrong with pages in a folder: a headless Chromium opens each as wide as a phone."""

import functools
import http.server
import json
import os
import re
import shutil
import signal
import subprocess
import tempfile
import threading

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
SECONDS = 240  # only ends a browser that hangs: 90 pages take 20 s
OPTIONS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
           "--disable-background-networking", "--disable-component-update", "--disable-breakpad",
           "--enable-logging=stderr")
VISITOR = """<!doctype html><meta charset="utf-8"><title>visitor</title><link rel="icon" href="data:,"><body><script>
const pages = PAGES, width = WIDTH, found = [], links = new Map();
const scrolls = element => element && element.nodeType == 1
  && (/auto|scroll/.test(element.ownerDocument.defaultView.getComputedStyle(element).overflowX)
      && element.tagName != "BODY" && element.tagName != "HTML"
      || scrolls(element.parentElement));
async function visit(page) {
  const frame = document.createElement("iframe");
  frame.style = `width: ${width}px; height: 800px; border: 0`;
  frame.src = page;
  const loaded = new Promise(done => { frame.onload = done; });
  document.body.append(frame);
  await loaded;
  const inside = frame.contentDocument;
  for (const image of inside.images) {
    image.loading = "eager";
    const name = image.getAttribute("src").slice(0, 80);
    await image.decode().catch(() => found.push(`${page}: no picture ${name}`));
  }
  const wide = [...inside.body.querySelectorAll("*")].filter(element => {
    const box = element.getBoundingClientRect();
    return box.width && box.right > inside.documentElement.clientWidth + 1 && !scrolls(element.parentElement);
  });
  const last = wide.at(-1);
  if (last) found.push(`${page}: wider than ${width} pixels: ${last.tagName} ${last.textContent.trim().slice(0, 60)}`);
  for (const link of inside.querySelectorAll("a[href]"))
    if (link.href.startsWith(location.origin)) links.set(link.href.split("#")[0], page);
  frame.remove();
}
(async () => {
  for (const page of pages) await visit(page).catch(error => found.push(`${page}: ${error}`));
  for (const [link, page] of links)
    if (!(await fetch(link, {method: "HEAD"})).ok)
      found.push(`${page}: broken link ${link.slice(location.origin.length)}`);
  await fetch("/found", {method: "POST", body: JSON.stringify(found)});
})();
</script>"""


class Server(http.server.SimpleHTTPRequestHandler):
    def do_GET(self):
        if self.path != "/visitor":
            super().do_GET()
            return
        self.send_response(200)
        self.send_header("Content-Type", "text/html; charset=utf-8")
        self.end_headers()
        self.wfile.write(self.server.visitor.encode())

    def do_POST(self):
        self.server.found += json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        self.send_response(204)
        self.end_headers()
        self.server.done.set()

    def log_message(self, *_):
        pass


def complaints(root, pages, width=400):
    """A line for each picture that does not load, link that leads nowhere, element that a window of so many pixels
    cuts, and message on the console, of pages whose paths are below the folder root."""
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Server, directory=root)) as server, \
            tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        server.visitor = VISITOR.replace("PAGES", json.dumps(pages)).replace("WIDTH", str(width))
        server.found, server.done = [], threading.Event()
        threading.Thread(target=server.serve_forever, daemon=True).start()
        with open(os.path.join(profile, "log"), "w+", encoding="utf-8", errors="replace") as log:
            browser = subprocess.Popen([BROWSER, *OPTIONS, f"--user-data-dir={profile}",
                                        f"http://127.0.0.1:{server.server_port}/visitor"],
                                       stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True)
            ended = server.done.wait(SECONDS)
            os.killpg(browser.pid, signal.SIGKILL)
            browser.wait()
            server.shutdown()
            log.seek(0)
            text = log.read()
        messages = [f"console: {message}" for message in re.findall(r"CONSOLE[:(]\d+\)?\] (.*)", text)]
        return server.found + messages + ([] if ended else [f"the browser did not end: {text[-1000:]}"])
