"""Progress bars for calls with on_progress=True."""


class Bar:
    """What is called with fractions from 0 to 1. Nothing is shown before the first of them, or after close()."""

    def __init__(self, make):
        self.make = make
        self.shown = None

    def __call__(self, fraction):
        if self.shown is None:
            self.shown = self.make()
        self.shown.update(100 * fraction - self.shown.n)

    def close(self):
        if self.shown is not None:
            self.shown.close()


def bar(name):
    """A bar of tqdm, or nothing where it is not installed."""
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return Bar(lambda: tqdm(total=100, desc=name, unit="%", bar_format="{desc}: {percentage:3.0f}%|{bar}| {elapsed}<{remaining}"))
