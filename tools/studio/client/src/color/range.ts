// From which number to which the colors of a map run: what most of it has, so that a few outliers do not make the rest dark; or what the user says.

const kOutside = 0.02;       // Of the numbers, beyond either end.
const kNarrow = 0.25;        // The range begins at 0 unless its low end is at least this share of its high one.
const kMostSorted = 200000;  // Of a larger map, every n-th.
const kMostDecades = 1e-4;   // A logarithmic range that would begin at 0 begins at this share of its end.

export interface MapRange {
  low: number;
  high: number;
  /// The smallest and the largest of all.
  least: number;
  most: number;
}

export type RangeMode = "auto" | "all" | "percentile" | "typed";

/// What the colors of a map stand for, as the user wants it.
export interface RangeChoice {
  mode: RangeMode;
  /// Left out at either end, of `percentile`.
  percent: number;
  /// Of `typed`.
  low: number;
  high: number;
  is_log: boolean;
}

export const kAutomatic: Readonly<RangeChoice> = { mode: "auto", percent: 1, low: 0, high: 1, is_log: false };

interface Sorted {
  found: Float32Array;
  least: number;
  most: number;
}

function sorted(values: Float32Array, counts: (v: number) => boolean): Sorted {
  let count = 0, least = Infinity, most = -Infinity;
  for (const v of values) {
    if (!Number.isFinite(v) || !counts(v)) continue;
    ++count;
    if (v > most) most = v;
    if (v < least) least = v;
  }
  if (count === 0) return { found: new Float32Array(), least: 0, most: 0 };
  const step = Math.ceil(count / kMostSorted);
  const found = new Float32Array(Math.ceil(count / step));
  let number = 0;
  for (const v of values) if (Number.isFinite(v) && counts(v) && number++ % step === 0) found[Math.floor((number - 1) / step)] = v;
  return { found: found.sort(), least, most };
}

const at = (found: Float32Array, share: number): number => found[Math.min(found.length - 1, Math.floor(share * found.length))] ?? 0;

/// As OverlayRange of tools/studio/overlay_plane.h, for maps that may be negative too: of the numbers that are neither 0 nor infinite.
export function range_of(values: Float32Array): MapRange {
  const { found, least, most } = sorted(values, (v) => v !== 0);
  if (found.length === 0) return { low: 0, high: 0, least, most };
  const low = at(found, kOutside), high = at(found, 1 - kOutside);
  if (low < 0) return { low, high: Math.max(high, 0), least, most };
  return { low: low >= kNarrow * high && low < high ? low : 0, high, least, most };
}

/// The range that a choice stands for. @param automatic  Of "auto", where it is known already.
export function chosen_range(values: Float32Array, choice: RangeChoice, automatic?: MapRange): MapRange {
  let range: MapRange;
  if (choice.mode === "auto") {
    range = { ...(automatic ?? range_of(values)) };
    // Both sides of 0 by the same steps, so that equal colors are equal numbers.
    if (range.low < 0 && range.high > 0) range.low = -(range.high = Math.max(-range.low, range.high));
  } else {
    const { found, least, most } = sorted(values, () => true);
    const share = choice.mode === "percentile" ? choice.percent / 100 : 0;
    range = choice.mode === "typed" ? { low: choice.low, high: choice.high, least, most } : { low: share > 0 ? at(found, share) : least, high: share > 0 ? at(found, 1 - share) : most, least, most };
  }
  if (choice.is_log && !(range.low > 0)) range.low = kMostDecades * range.high;
  return range;
}

/// Where a number stands in a range, [0, 1]; of a range over 0, 0 stands in the middle.
export function share_in(value: number, { low, high }: { low: number; high: number }, is_log: boolean): number {
  if (is_log) return Math.log(Math.max(value, 1e-30) / low) / Math.log(high / low);
  if (low < 0 && high > 0) return value < 0 ? 0.5 - (0.5 * value) / low : 0.5 + (0.5 * value) / high;
  return (value - low) / (high - low);
}
