"""The moving pictures of odom watch and of odom serve's page: pictures.py BUILD_DIR FOLDER

Drives a simulated lap, with a gap in the camera's poses, into odomd in real time, once for each picture. odom watch
runs in a terminal of 120 x 40, drawn in DejaVu Sans Mono; the page in Chromium without a window. Writes watch.gif and
web.gif."""
import base64
import fcntl
import io
import os
import pathlib
import pty
import selectors
import struct
import subprocess
import sys
import tempfile
import termios
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pyte  # python3-pyte
from PIL import Image, ImageDraw, ImageFont  # python3-pil
from pyte.screens import Char

from serve_screenshots import browser

COLUMNS, ROWS, SECONDS, PERIOD_S = 120, 40, 22.0, 0.75
SIZE, CELL = 13, (8, 16)
COLOURS = {"default": "#d8dee4", "black": "#0d1117", "red": "#ff7b72", "green": "#5fd068", "brown": "#e3b341",
           "blue": "#79c0ff", "magenta": "#d2a8ff", "cyan": "#56d4dd", "white": "#f0f6fc"}
FONT = "/usr/share/fonts/truetype/dejavu/DejaVuSansMono{}.ttf"
PLAIN, BOLD = (ImageFont.truetype(FONT.format(style), SIZE) for style in ("", "-Bold"))


def colour(name: str, default: str) -> str:
    name = default if name == "default" else name.removeprefix("bright")
    return COLOURS.get(name) or "#" + name


def drawn(cells: list[list[Char]]) -> Image.Image:
    picture = Image.new("RGB", (COLUMNS * CELL[0], ROWS * CELL[1]), COLOURS["black"])
    draw = ImageDraw.Draw(picture)
    for y, x in ((y, x) for y in range(ROWS) for x in range(COLUMNS)):
        cell, at = cells[y][x], (x * CELL[0], y * CELL[1])
        ink, paper = colour(cell.fg, "default"), colour(cell.bg, "black")
        if cell.reverse:
            ink, paper = paper, ink
        if paper != COLOURS["black"]:
            draw.rectangle((*at, at[0] + CELL[0] - 1, at[1] + CELL[1] - 1), paper)
        if "\u2800" < cell.data <= "\u28ff":  # braille, which the font lacks
            for bit, (column, row) in enumerate(((0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (0, 3), (1, 3))):
                if ord(cell.data) >> bit & 1:
                    dot = at[0] + 1 + 4 * column, at[1] + 1 + 4 * row
                    draw.rectangle((*dot, dot[0] + 1, dot[1] + 1), ink)
        else:
            draw.text(at, cell.data, ink, BOLD if cell.bold else PLAIN)
    return picture


@contextmanager
def drive(run: pathlib.Path) -> Iterator[list[str]]:
    """odomd on a live simulated lap; gives the options of its segment and its socket."""
    run.mkdir()
    sim = ["odom", "sim", "--laps", "2", "--seed", "2", "--live", "--can", "-", "--camera-dropout", "12:5",
           "--camera-socket", str(run / "camera.sock")]
    subprocess.run([*sim, "--config-only", "--out", str(run / "car")], check=True, stdout=subprocess.DEVNULL)
    with (subprocess.Popen([*sim, "--out", str(run / "drive")], stdout=subprocess.PIPE,
                           stderr=subprocess.DEVNULL) as car,
          subprocess.Popen(["odomd", "--config", "car/car.toml", "--can", "-", "--runtime-directory", str(run),
                            "--log-level", "error"], stdin=car.stdout, cwd=run) as daemon):
        time.sleep(1.5)
        try:
            yield ["--shm", str(run / "pose"), "--socket", str(run / "status.sock")]
        finally:
            car.terminate()
            daemon.terminate()


def watched(options: list[str]) -> Iterator[Image.Image]:
    screen = pyte.Screen(COLUMNS, ROWS)
    stream = pyte.ByteStream(screen)
    shots: list[list[list[Char]]] = []
    pid, terminal = pty.fork()
    if pid == 0:
        os.execvpe("odom", ["odom", "watch", *options], {**os.environ, "TERM": "xterm-256color", "LANG": "C.UTF-8"})
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", ROWS, COLUMNS, 0, 0))
    with selectors.DefaultSelector() as ready:
        ready.register(terminal, selectors.EVENT_READ)
        begin = time.monotonic()
        while (now := time.monotonic() - begin) < SECONDS:
            end = begin + (now // PERIOD_S + 1) * PERIOD_S
            while ready.select(max(end - time.monotonic(), 0.0)):
                stream.feed(os.read(terminal, 65536))
            shots.append([[screen.buffer[y][x] for x in range(COLUMNS)] for y in range(ROWS)])
    os.write(terminal, b"q")
    os.waitpid(pid, 0)
    return map(drawn, shots)  # drawing takes time


def browsed(options: list[str]) -> Iterator[Image.Image]:
    server = subprocess.Popen(["odom", "serve", "--listen", "127.0.0.1:0", *options], stderr=subprocess.PIPE, text=True)
    try:
        url = next(word for line in server.stderr for word in line.split() if word.startswith("http://"))
        with browser() as tab:
            tab.call("Emulation.setDeviceMetricsOverride", width=1280, height=780, deviceScaleFactor=0.7, mobile=False)
            tab.call("Page.navigate", url=url)
            begin = time.monotonic()
            while (now := time.monotonic() - begin) < SECONDS:
                time.sleep(PERIOD_S - now % PERIOD_S)
                shot = base64.b64decode(tab.call("Page.captureScreenshot")["data"])
                yield Image.open(io.BytesIO(shot)).convert("RGB")
    finally:
        server.terminate()
        server.wait()


def main(build: pathlib.Path, folder: pathlib.Path) -> None:
    os.environ["PATH"] = f"{build.resolve()}/bin:{os.environ['PATH']}"
    folder.mkdir(parents=True, exist_ok=True)
    for name, frames_of in (("watch", watched), ("web", browsed)):
        with tempfile.TemporaryDirectory() as scratch, drive(pathlib.Path(scratch) / "run") as options:
            frames = list(frames_of(options))[2:]
        # Few colours, the most common and the vivid ones, are shared by all frames: unchanged areas
        # cost nothing.
        strip = Image.new("RGB", (frames[0].width, 4 * frames[0].height))
        for i in range(4):
            strip.paste(frames[i * (len(frames) - 1) // 3], (0, i * frames[0].height))
        common = [rgb for _, rgb in sorted(strip.getcolors(1 << 24), reverse=True)[:20]]
        palette = Image.new("P", (1, 1))
        palette.putpalette([*sum(common, ()), *strip.quantize(16, Image.Quantize.MAXCOVERAGE).getpalette()[:48]])
        frames = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
        file = folder / f"{name}.gif"
        frames[0].save(file, save_all=True, append_images=frames[1:], duration=int(1e3 * PERIOD_S), loop=0)
        subprocess.run(["convert", file, "-layers", "OptimizeTransparency", file], check=True)
        print(f"{file}: {len(frames)} frames, {file.stat().st_size // 1000} kB")
        assert file.stat().st_size < 400_000


if __name__ == "__main__":
    main(*map(pathlib.Path, sys.argv[1:]))
