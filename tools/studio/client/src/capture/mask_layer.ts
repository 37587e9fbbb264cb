// The mask of a photograph, shown over it: what is outside is tinted.
import { get, url_of } from "../api";
import { h } from "../ui/dom";
import { Mask, type Box } from "./mask";

const kMostWidth = 3000, kTint = [214, 54, 40, 150] as const;

export class MaskLayer {
  readonly canvas = h("canvas", { class: "mask-layer" });
  private readonly context = this.canvas.getContext("2d")!;

  constructor(readonly mask: Mask) {
    const shrink = Math.min(1, kMostWidth / mask.width);
    this.canvas.width = Math.max(1, Math.round(mask.width * shrink));
    this.canvas.height = Math.max(1, Math.round(mask.height * shrink));
  }

  show({ x0, y0, x1, y1 }: Box): void {
    const { mask, canvas } = this, sx = mask.width / canvas.width, sy = mask.height / canvas.height;
    const left = Math.floor(x0 / sx), top = Math.floor(y0 / sy), width = Math.ceil(x1 / sx) - left, height = Math.ceil(y1 / sy) - top;
    if (width <= 0 || height <= 0) return;
    const pixels = this.context.createImageData(width, height);
    for (let y = 0; y < height; ++y) {
      const row = Math.min(mask.height - 1, Math.floor((top + y + 0.5) * sy)) * mask.width;
      for (let x = 0; x < width; ++x) if (!mask.inside[row + Math.min(mask.width - 1, Math.floor((left + x + 0.5) * sx))]) pixels.data.set(kTint, 4 * (y * width + x));
    }
    this.context.putImageData(pixels, left, top);
  }
}

function canvas_of(width: number, height: number): CanvasRenderingContext2D {
  const canvas = h("canvas", {});
  canvas.width = width;
  canvas.height = height;
  return canvas.getContext("2d", { willReadFrequently: true })!;
}

/// Takes the mask of a project.
export async function read_mask(place: string, mask: Mask): Promise<void> {
  const reply = await get(url_of("/api/mask", { place }));
  const picture = await createImageBitmap(new Blob([reply.bytes], { type: "image/png" }));
  if (picture.width !== mask.width || picture.height !== mask.height) return;
  const context = canvas_of(mask.width, mask.height);
  context.drawImage(picture, 0, 0);
  const { data } = context.getImageData(0, 0, mask.width, mask.height);
  for (let i = 0; i < mask.inside.length; ++i) mask.inside[i] = data[4 * i]! > 127 ? 255 : 0;
}

/// As a PNG.
export async function mask_file({ width, height, inside }: Mask): Promise<Blob> {
  const context = canvas_of(width, height), pixels = context.createImageData(width, height), words = new Uint32Array(pixels.data.buffer);
  for (let i = 0; i < inside.length; ++i) words[i] = inside[i] ? 0xffffffff : 0xff000000;
  context.putImageData(pixels, 0, 0);
  return new Promise((done, fail) => context.canvas.toBlob((blob) => (blob ? done(blob) : fail(new Error("The browser cannot make a picture of this mask."))), "image/png"));
}

/// What a picture on the page shows.
export function pixels_of(image: HTMLImageElement): ImageData {
  const context = canvas_of(image.naturalWidth, image.naturalHeight);
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, image.naturalWidth, image.naturalHeight);
}
