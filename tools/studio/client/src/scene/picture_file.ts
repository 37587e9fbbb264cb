// Surroundings from a file of the user's: Radiance HDR or OpenEXR, 360 degrees wide.
import * as THREE from "three";
import { EXRLoader } from "three/addons/loaders/EXRLoader.js";
import { RGBELoader } from "three/addons/loaders/RGBELoader.js";
import { StudioError } from "../api";
import type { RadianceMap } from "./environment";

const kMostWidth = 1024;  // A mirror as smooth as a film of water sees no more of it.

/// Rows from the top. @throws StudioError
export async function read_surroundings(file: File): Promise<RadianceMap> {
  const bytes = await file.arrayBuffer(), is_exr = /\.exr$/i.test(file.name);
  try {
    const { width, height, data } = (is_exr ? new EXRLoader() : new RGBELoader()).setDataType(THREE.FloatType).parse(bytes) as unknown as { width: number; height: number; data: Float32Array };
    return reduced({ width, height, data, channels: data.length / (width * height), is_from_top: !is_exr });
  } catch (error) {
    throw new StudioError(`${file.name} cannot be read as HDR or EXR: ${(error as Error).message}`);
  }
}

interface Picture {
  width: number;
  height: number;
  data: Float32Array;
  channels: number;
  is_from_top: boolean;
}

/// Means of squares of pixels, so that it is at most kMostWidth wide.
export function reduced({ width, height, data, channels, is_from_top }: Picture): RadianceMap {
  const by = Math.max(1, Math.ceil(width / kMostWidth)), w = Math.floor(width / by), h = Math.max(1, Math.floor(height / by));
  const rgb = new Float32Array(3 * w * h);
  for (let y = 0; y < h * by; ++y) {
    const row = is_from_top ? y : height - 1 - y, to = 3 * Math.floor(y / by) * w;
    for (let x = 0; x < w * by; ++x) {
      for (let c = 0; c < 3; ++c) rgb[to + 3 * Math.floor(x / by) + c]! += data[channels * (row * width + x) + Math.min(c, channels - 1)]! / (by * by);
    }
  }
  return { width: w, height: h, rgb };
}
