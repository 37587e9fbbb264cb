// From which number to which the colors of a map run: what most of it has, so that a few outliers do not make the rest dark.

const kOutside = 0.02;       // Of the numbers, beyond either end.
const kNarrow = 0.25;        // The range begins at 0 unless its low end is at least this share of its high one.
const kMostSorted = 200000;  // Of a larger map, every n-th.

export interface MapRange {
  low: number;
  high: number;
  /// The largest of all.
  most: number;
}

/// As OverlayRange of tools/studio/overlay_plane.h, for maps that may be negative too: of the numbers that are neither 0 nor infinite.
export function range_of(values: Float32Array): MapRange {
  let count = 0, most = -Infinity;
  for (const v of values) {
    if (!Number.isFinite(v) || v === 0) continue;
    ++count;
    if (v > most) most = v;
  }
  if (count === 0) return { low: 0, high: 0, most: 0 };
  const step = Math.ceil(count / kMostSorted);
  const found = new Float32Array(Math.ceil(count / step));
  let number = 0;
  for (const v of values) if (Number.isFinite(v) && v !== 0 && number++ % step === 0) found[Math.floor((number - 1) / step)] = v;
  found.sort();
  const at = (share: number): number => found[Math.min(found.length - 1, Math.floor(share * found.length))]!;
  const low = at(kOutside), high = at(1 - kOutside);
  if (low < 0) return { low, high: Math.max(high, 0), most };
  return { low: low >= kNarrow * high && low < high ? low : 0, high, most };
}
