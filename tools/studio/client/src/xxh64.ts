// XXH64 of bytes, seed 0, as the server counts it: 16 hex digits. Slow (BigInt) and plain: for checking what is on screen.
const kP1 = 0x9e3779b185ebca87n, kP2 = 0xc2b2ae3d27d4eb4fn, kP3 = 0x165667b19e3779f9n, kP4 = 0x85ebca77c2b2ae63n, kP5 = 0x27d4eb2f165667c5n;
const u64 = (x: bigint): bigint => BigInt.asUintN(64, x);
const rotate = (x: bigint, n: bigint): bigint => u64((x << n) | (x >> (64n - n)));
const round = (acc: bigint, lane: bigint): bigint => u64(rotate(u64(acc + u64(lane * kP2)), 31n) * kP1);
const merge = (acc: bigint, lane: bigint): bigint => u64(u64(acc ^ round(0n, lane)) * kP1 + kP4);

export function xxh64(bytes: Uint8Array): string {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const length = bytes.byteLength;
  let at = 0;
  let hash: bigint;
  if (length >= 32) {
    let a = u64(kP1 + kP2), b = kP2, c = 0n, d = u64(-kP1);
    for (; at + 32 <= length; at += 32) {
      a = round(a, view.getBigUint64(at, true));
      b = round(b, view.getBigUint64(at + 8, true));
      c = round(c, view.getBigUint64(at + 16, true));
      d = round(d, view.getBigUint64(at + 24, true));
    }
    hash = u64(rotate(a, 1n) + rotate(b, 7n) + rotate(c, 12n) + rotate(d, 18n));
    for (const lane of [a, b, c, d]) hash = merge(hash, lane);
  } else {
    hash = kP5;
  }
  hash = u64(hash + BigInt(length));
  for (; at + 8 <= length; at += 8) hash = u64(rotate(hash ^ round(0n, view.getBigUint64(at, true)), 27n) * kP1 + kP4);
  if (at + 4 <= length) {
    hash = u64(rotate(hash ^ u64(BigInt(view.getUint32(at, true)) * kP1), 23n) * kP2 + kP3);
    at += 4;
  }
  for (; at < length; ++at) hash = u64(rotate(hash ^ u64(BigInt(view.getUint8(at)) * kP5), 11n) * kP1);
  hash = u64((hash ^ (hash >> 33n)) * kP2);
  hash = u64((hash ^ (hash >> 29n)) * kP3);
  return (hash ^ (hash >> 32n)).toString(16).padStart(16, "0");
}
