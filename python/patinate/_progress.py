"""Progress bars for calls with on_progress=True."""


def bar(name):
    """What is called with fractions from 0 to 1: a bar of tqdm, or nothing where it is not installed."""
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    shown = tqdm(total=100, desc=name, unit="%", bar_format="{desc}: {percentage:3.0f}%|{bar}| {elapsed}<{remaining}")

    def update(fraction):
        shown.update(100 * fraction - shown.n)
        if fraction >= 1:
            shown.close()
    return update
