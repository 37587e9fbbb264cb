// A texture that changes by tiles: a copy in memory, bit by bit what the server has, and uploads of few rectangles.
import * as THREE from "three";

export interface Rect {
  x: number;
  y: number;
  width: number;
  height: number;
}

const kMostRects = 96;
const kGap = 3;

function is_sorted(tiles: Uint32Array): boolean {
  for (let i = 1; i < tiles.length; ++i) if (tiles[i - 1]! > tiles[i]!) return false;
  return true;
}

/// Few rectangles (in tiles) that cover all tiles: runs along rows, with small gaps closed, joined downwards; where there are too many, whole bands.
/// @param tiles  Numbers, row by row over `columns`; any order.
export function merge_tiles(tiles: Uint32Array, columns: number): Rect[] {
  const sorted = is_sorted(tiles) ? tiles : tiles.slice().sort();
  for (let gap = kGap; ; gap = 4 * gap + 4) {
    const rects: Rect[] = [];
    let open = new Map<string, Rect>();
    let i = 0;
    while (i < sorted.length) {
      const y = Math.floor(sorted[i]! / columns);
      const next = new Map<string, Rect>();
      while (i < sorted.length && Math.floor(sorted[i]! / columns) === y) {
        const first = sorted[i]! % columns;
        let last = first;
        for (++i; i < sorted.length && Math.floor(sorted[i]! / columns) === y && (sorted[i]! % columns) - last <= gap + 1; ++i) last = sorted[i]! % columns;
        const key = gap > columns ? "band" : `${first} ${last}`;
        const above = open.get(key);
        if (above && above.y + above.height === y) {
          above.height += 1;
          const right = Math.max(above.x + above.width, last + 1);
          above.x = Math.min(above.x, first);
          above.width = right - above.x;
          next.set(key, above);
        } else {
          const rect = { x: first, y, width: last - first + 1, height: 1 };
          rects.push(rect);
          next.set(key, rect);
        }
      }
      open = next;
    }
    if (rects.length <= kMostRects || gap > columns) return rects;
  }
}

const kMipsWait_ms = 400;

export class TilePlane {
  readonly data: Uint8Array;
  readonly texture: THREE.DataTexture;
  num_uploads = 0;
  private readonly texels: Uint32Array | Uint8Array;
  private dirty: Rect[] = [];
  private mips_timer: number | undefined;
  private are_mips_stale = false;
  private has_mips = true;

  constructor(readonly width: number, readonly height: number, readonly bytes_per_texel: 1 | 4, is_color: boolean, private readonly on_calm: () => void) {
    this.data = new Uint8Array(width * height * bytes_per_texel);
    this.texels = bytes_per_texel === 4 ? new Uint32Array(this.data.buffer) : this.data;
    this.texture = new THREE.DataTexture(this.data, width, height, bytes_per_texel === 4 ? THREE.RGBAFormat : THREE.RedFormat, THREE.UnsignedByteType);
    if (is_color) this.texture.colorSpace = THREE.SRGBColorSpace;
    this.texture.magFilter = THREE.LinearFilter;
    this.texture.minFilter = THREE.LinearMipmapLinearFilter;
    this.texture.generateMipmaps = true;
    this.texture.unpackAlignment = 1;
    this.texture.needsUpdate = true;
  }

  /// Tiles as they come: `count` numbers, then their texels, row by row.
  apply(message: ArrayBuffer, offset: number, count: number, side: number): void {
    const numbers = new Uint32Array(message, offset, count);
    const columns = Math.ceil(this.width / side);
    // Texels of four bytes are copied as one number each; the message is aligned for that.
    const from = this.bytes_per_texel === 4 ? new Uint32Array(message, offset + 4 * count, count * side * side) : new Uint8Array(message, offset + 4 * count, count * side * side);
    const to = this.texels;
    for (let i = 0; i < count; ++i) {
      const x = (numbers[i]! % columns) * side, y = Math.floor(numbers[i]! / columns) * side;
      const rows = Math.min(side, this.height - y), width = Math.min(side, this.width - x);
      for (let r = 0; r < rows; ++r) {
        let a = (i * side + r) * side, b = (y + r) * this.width + x;
        for (const end = a + width; a < end; ++a, ++b) to[b] = from[a]!;
      }
    }
    for (const rect of merge_tiles(numbers, columns)) {
      this.dirty.push({ x: rect.x * side, y: rect.y * side, width: Math.min(rect.width * side, this.width - rect.x * side), height: Math.min(rect.height * side, this.height - rect.y * side) });
    }
  }

  /// Before drawing. Mipmaps are made again only when no tiles have come for a while: they cost more than the tiles.
  upload(renderer: THREE.WebGLRenderer): void {
    if (this.dirty.length === 0) {
      if (this.are_mips_stale) this.refresh_mips(renderer);
      return;
    }
    const handle = (renderer.properties.get(this.texture) as { __webglTexture?: WebGLTexture }).__webglTexture;
    if (!handle) {  // Not on the graphics card yet: three.js uploads all of it.
      this.texture.needsUpdate = true;
      this.dirty = [];
      return;
    }
    const gl = renderer.getContext() as WebGL2RenderingContext;
    this.bind(renderer, gl, handle);
    if (this.has_mips) {
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
      this.has_mips = false;
    }
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, this.width);
    const format = this.bytes_per_texel === 4 ? gl.RGBA : gl.RED;
    for (const { x, y, width, height } of this.dirty) {
      gl.pixelStorei(gl.UNPACK_SKIP_PIXELS, x);
      gl.pixelStorei(gl.UNPACK_SKIP_ROWS, y);
      gl.texSubImage2D(gl.TEXTURE_2D, 0, x, y, width, height, format, gl.UNSIGNED_BYTE, this.data);
    }
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 0);
    gl.pixelStorei(gl.UNPACK_SKIP_PIXELS, 0);
    gl.pixelStorei(gl.UNPACK_SKIP_ROWS, 0);
    renderer.state.unbindTexture();
    this.num_uploads += this.dirty.length;
    this.dirty = [];
    window.clearTimeout(this.mips_timer);
    this.mips_timer = window.setTimeout(() => {
      this.are_mips_stale = true;
      this.on_calm();
    }, kMipsWait_ms);
  }

  dispose(): void {
    window.clearTimeout(this.mips_timer);
    this.texture.dispose();
  }

  private bind(renderer: THREE.WebGLRenderer, gl: WebGL2RenderingContext, handle: WebGLTexture): void {
    renderer.state.activeTexture(gl.TEXTURE0);
    renderer.state.bindTexture(gl.TEXTURE_2D, handle);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  }

  private refresh_mips(renderer: THREE.WebGLRenderer): void {
    this.are_mips_stale = false;
    const handle = (renderer.properties.get(this.texture) as { __webglTexture?: WebGLTexture }).__webglTexture;
    if (!handle) return;
    const gl = renderer.getContext() as WebGL2RenderingContext;
    this.bind(renderer, gl, handle);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    renderer.state.unbindTexture();
    this.has_mips = true;
  }
}
