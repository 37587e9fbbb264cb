// Figure 10 of "GPU-accelerated Interactive Material Aging": one slider from dry grains that bounce to water that creeps, and its four curves.
import type { Behavior } from "../types";
import { chart, type Chart } from "../ui/chart";

const clamp = (x: number): number => Math.min(Math.max(x, 0), 1);

/// As behavior_of_slider() of simulation/include/patinate/simulation/scene.h.
export function behavior_of_slider(s: number, absorb: number): Behavior {
  const alive = 1 - absorb, floats = clamp(3 * s - 1);
  return { bounce: alive - alive * floats, float: alive * floats, absorb, deceleration_bounce: 0.9 * clamp(3 * s), deceleration_float: clamp(3 * s - 2) };
}

const kNumPoints = 61;

export function figure10(absorb: number, on_slider: (s: number) => void): Chart {
  const x = Array.from({ length: kNumPoints }, (_, i) => i / (kNumPoints - 1));
  const all = x.map((s) => behavior_of_slider(s, absorb));
  const line = (name: string, key: keyof Behavior, style: string) => ({ name, x, y: all.map((b) => b[key]), style });
  return chart([line("bounces", "bounce", "series-2"), line("floats", "float", "series-3"), line("slows at a bounce", "deceleration_bounce", "series-1"), line("slows while floating", "deceleration_float", "series-4")],
    { label: "What gammatons do at a hit, over the slider: bounce, float, and how much speed each costs", x_label: "slider", low: 0, high: 1, height: 140, on_x: on_slider });
}
