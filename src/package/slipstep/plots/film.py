"""A film of a run: a field over the fault, a frame for each stored row or at equal steps of time or of the logarithm of
the largest slip rate, which is below."""

import os
import subprocess

import numpy as np
from matplotlib import animation
from matplotlib.colors import to_rgb
from matplotlib.ticker import MaxNLocator
from PIL import Image

from ..errors import OutputError
from ..results.fields import Fields, largest_rates
from ..times import SECONDS, Clock
from .maps import Span, colour_bar
from .panels import RED, RUN_STYLES, plt
from .snapshots import WIDTH, Layout
from .titles import titles_of

DPI = 100
PACES = "rows", "time", "rate"
EVEN = "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white"  # numbers of pixels that mp4 needs


class Gif(animation.AbstractMovieWriter):
    """A GIF whose one palette has the colours of the maps, so that they neither flicker nor fall into steps."""

    colours = "magma"

    def setup(self, fig, outfile, dpi=None):
        super().setup(fig, outfile, dpi)
        self.frames = []
        greys = np.repeat(np.linspace(0, 1, 30)[:, None], 3, axis=1)
        inks = [share * np.array(to_rgb(ink)) + 1 - share for ink in (RED, RUN_STYLES[0]["color"])
                for share in np.linspace(0.1, 1, 8)]
        shown = plt.get_cmap(self.colours)(np.linspace(0, 1, 210))[:, :3]
        self.palette = Image.new("P", (1, 1))
        self.palette.putpalette(np.round(255 * np.concatenate([shown, greys, inks])).astype(np.uint8).tobytes())

    def grab_frame(self, **options):
        frame = Image.fromarray(np.asarray(self.fig.canvas.buffer_rgba())).convert("RGB")
        self.frames.append(frame.quantize(palette=self.palette, dither=Image.Dither.NONE))

    def finish(self):
        first, *others = self.frames
        first.save(self.outfile, format="GIF", save_all=True, append_images=others, duration=1000 / self.fps, loop=0)


class Mp4(animation.FFMpegWriter):
    """Sends what the canvas shows, in place of drawing all of it anew for each frame."""

    def grab_frame(self, **options):
        self._proc.stdin.write(self.fig.canvas.buffer_rgba())


class Stage:
    """A figure of which a few artists move: the rest is drawn once, which makes a film five times as fast."""

    def __init__(self, canvas, moving):
        self.canvas = canvas.canvas
        for artist in moving:
            artist.set_animated(True)
        self.canvas.draw()
        canvas.set_layout_engine("none")
        self.still = self.canvas.copy_from_bbox(canvas.bbox)
        rims = [spine for artist in moving if artist.axes for spine in artist.axes.spines.values()]
        self.drawn = sorted(moving, key=lambda artist: artist.zorder) + rims

    def draw(self):
        self.canvas.restore_region(self.still)
        for artist in self.drawn:
            artist.draw(self.canvas.get_renderer())


def writer(path, rate):
    """What writes a film with this ending; an error says what there is."""
    ending = os.path.splitext(path)[1].lower()
    if ending not in (".mp4", ".gif"):
        raise OutputError(f"--film is {path}, expected a name that ends with .mp4 or .gif")
    folder = os.path.dirname(os.path.abspath(path))
    if not os.path.isdir(folder):
        raise OutputError(f"--film is {path}, but there is no folder {folder}")
    if ending == ".gif":
        return Gif(fps=rate)
    if not animation.FFMpegWriter.isAvailable():
        raise OutputError(f"--film is {path}, but there is no program ffmpeg (Debian's package ffmpeg); a name that "
                          "ends with .gif needs none")
    return Mp4(fps=rate, codec="libx264", extra_args=["-vf", EVEN, "-pix_fmt", "yuv420p", "-crf", "18"])


def positive(rates):
    """Rates of a logarithmic scale; at rest there are none."""
    return np.where(rates > 0, rates, np.nan)


def draw_course(axes, run, fields, rows, clock):
    """The largest slip rate, against time, or, where that would hide the events, at each frame; the dot that moves."""
    times, series = largest_rates(run)
    rates = np.interp(fields.times[rows], times, series)
    long = SECONDS[clock.unit] > 1
    at = np.arange(len(rows)) if long else clock(fields.times[rows])
    axes.plot(at if long else clock(times), positive(rates if long else series), color=RUN_STYLES[0]["color"],
              linewidth=1.0)
    dot, = axes.plot(at[:1], rates[:1], marker="o", markersize=6, color=RED, linestyle="")
    axes.set(xlabel="frame" if long else clock.label, ylabel="largest slip rate\n(m/s)",
             xlim=(at[0], at[-1] if at[-1] > at[0] else at[0] + 1))
    axes.xaxis.set_major_locator(MaxNLocator(8, integer=long, steps=[1, 2, 5, 10]))
    drawn = rates if long else np.append(rates,
                                         series[(times >= fields.times[rows[0]]) & (times <= fields.times[rows[-1]])])
    if (drawn > 0).any():
        axes.set_yscale("log")
        axes.set_ylim(max(drawn[drawn > 0].min(), drawn.max() * 1e-13) / 2, drawn.max() * 3)
    return at, rates, dot


def paced(run, times, pace, frames):
    """Numbers of the stored rows at times [n] that a film of so many frames at most shows, the first and the last among
    them: equally many rows apart; or those nearest to equal steps of time, a row again where none is nearer; or of the
    way that the logarithm of the largest slip rate goes up and down, which passes quiet years at once."""
    count = min(len(times), frames)
    way = times
    if pace == "rate":
        at, rates = largest_rates(run)
        at, rates = at[rates > 0], rates[rates > 0]
        way = (np.interp(times, at, np.append(0.0, np.cumsum(np.abs(np.diff(np.log(rates)))))) if len(at) > 1
               else 0 * times)
    if pace == "rows" or not way[-1] > way[0]:
        way = np.arange(len(times), dtype=float)
    rows = np.searchsorted((way[1:] + way[:-1]) / 2, np.linspace(way[0], way[-1], count))
    rows[-1] = len(times) - 1  # also after quiet years
    return rows if pace == "time" else np.unique(rows)


def film(run, path, name, window=None, log=True, wanted=None, years=None, rate=15.0, frames=500, pace="rows"):
    """Write the film; the numbers of its frames and of the stored rows."""
    out = writer(path, rate)
    fields = Fields(run, name, window)
    out.colours = fields.kind.colours
    rows = paced(run, fields.times, pace, frames)
    log = log and name == "slip_rate"
    span = Span()
    for _, maps in fields.chunks(rows):
        span.see(np.abs(maps) if log else maps)
    norm = span.norm(fields.kind, log, wanted)
    clock = Clock(*fields.times[rows][[0, -1]], years)
    shown, number = np.unique(rows, return_inverse=True)
    titles = titles_of(run, fields.times[shown], clock)
    layout = Layout(run, 1, 1)
    canvas = layout.canvas
    height = min(canvas.get_figheight() * 0.8, 7.0)
    canvas.set_size_inches(0.8 * WIDTH, height + 1.7)
    above, below = canvas.subfigures(2, 1, height_ratios=(height, 1.7))
    block = layout.fill(above)[0]
    artists = layout.draw(block, fields.maps(rows[:1])[0], norm, fields.kind.colours, "", True)
    colour_bar(above, artists[0], norm, fields.label, ax=block, aspect=25, pad=0.02, shrink=0.85)
    title = above.suptitle(titles[number[0]])
    at, rates, dot = draw_course(below.subplots(), run, fields, rows, clock)
    canvas.set_dpi(DPI)
    stage = Stage(canvas, [*artists, title, dot])
    try:
        with out.saving(canvas, path, DPI):
            for frame, values in enumerate(values for _, maps in fields.chunks(rows) for values in maps):
                for plane, artist in zip(layout.planes, artists):
                    artist.show(plane.values(np.abs(values) if log else values))
                title.set_text(titles[number[frame]])
                dot.set_data(at[frame:frame + 1], positive(rates)[frame:frame + 1])
                stage.draw()
                out.grab_frame()
    except (subprocess.CalledProcessError, BrokenPipeError) as error:
        raise OutputError(f"{path}: ffmpeg could not write it ({error})") from error
    plt.close(canvas)
    return len(rows), len(fields.rows)
