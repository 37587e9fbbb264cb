// Light to look at surfaces in: small scenes, turned into reflections and ambient light, and one lamp that casts shadows.
import * as THREE from "three";

export interface LightChoice {
  name: string;
  text: string;
  zenith: number;
  horizon: number;
  ground: number;
  /// Of the lamp: color, strength, degrees above the horizon, degrees around.
  lamp: { color: number; strength: number; height_deg: number; around_deg: number };
  ambient: number;
  /// Bright panels in the reflections: [azimuth, height, half width (degrees), strength].
  panels: [number, number, number, number][];
}

export const kLights: LightChoice[] = [
  { name: "studio", text: "Studio", zenith: 0x8d9094, horizon: 0x7c7f83, ground: 0x6b6661, lamp: { color: 0xfff3e4, strength: 1.7, height_deg: 46, around_deg: 35 }, ambient: 0.8, panels: [[40, 45, 16, 4.5], [-60, 30, 22, 1.8], [165, 38, 14, 3]] },
  { name: "overcast", text: "Overcast sky", zenith: 0xe2e8ee, horizon: 0xc2c8cc, ground: 0x77736b, lamp: { color: 0xffffff, strength: 0.7, height_deg: 75, around_deg: 20 }, ambient: 0.95, panels: [] },
  { name: "sun", text: "Sun", zenith: 0x5d8fcc, horizon: 0xbfd4e6, ground: 0x59503f, lamp: { color: 0xfff0d2, strength: 2.6, height_deg: 52, around_deg: -40 }, ambient: 0.7, panels: [[-40, 52, 5, 12]] },
  { name: "evening", text: "Evening", zenith: 0x2d3f66, horizon: 0xe2955a, ground: 0x2c2522, lamp: { color: 0xffb06a, strength: 2.4, height_deg: 14, around_deg: 60 }, ambient: 0.6, panels: [[60, 12, 7, 12]] },
  { name: "raking", text: "Raking light (relief)", zenith: 0x2a2b2d, horizon: 0x242527, ground: 0x18181a, lamp: { color: 0xffffff, strength: 3.6, height_deg: 9, around_deg: 75 }, ambient: 0.5, panels: [[75, 12, 10, 6]] },
];

export function light_named(name: string): LightChoice {
  return kLights.find((l) => l.name === name) ?? kLights[0]!;
}

/// Unit vector toward the lamp, y up.
export function lamp_direction(light: LightChoice, turn_deg = 0): THREE.Vector3 {
  const [height, around] = [light.lamp.height_deg, light.lamp.around_deg + turn_deg].map((d) => (d * Math.PI) / 180) as [number, number];
  return new THREE.Vector3(Math.cos(height) * Math.sin(around), Math.sin(height), Math.cos(height) * Math.cos(around));
}

function sky_material(light: LightChoice): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    side: THREE.BackSide,
    uniforms: { zenith: { value: new THREE.Color(light.zenith) }, horizon: { value: new THREE.Color(light.horizon) }, ground: { value: new THREE.Color(light.ground) } },
    vertexShader: "varying vec3 way; void main() { way = position; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }",
    fragmentShader: `varying vec3 way; uniform vec3 zenith, horizon, ground;
      void main() {
        float h = normalize(way).y;
        gl_FragColor = vec4(h > 0.0 ? mix(horizon, zenith, pow(h, 0.6)) : mix(horizon, ground, smoothstep(0.0, 0.12, -h)), 1.0);
      }`,
  });
}

/// Reflections of a light, made once each.
export class Environments {
  private readonly made = new Map<string, THREE.WebGLRenderTarget>();

  constructor(private readonly renderer: THREE.WebGLRenderer) {}

  get(name: string): THREE.Texture {
    const light = light_named(name);
    let target = this.made.get(light.name);
    if (!target) {
      const scene = new THREE.Scene();
      const sky = new THREE.Mesh(new THREE.SphereGeometry(50, 32, 24), sky_material(light));
      scene.add(sky);
      for (const [around, height, half, strength] of light.panels) {
        const side = 2 * 40 * Math.tan((half * Math.PI) / 180);
        const panel = new THREE.Mesh(new THREE.PlaneGeometry(side, side), new THREE.MeshBasicMaterial({ color: new THREE.Color(light.lamp.color).multiplyScalar(strength), side: THREE.DoubleSide }));
        panel.position.copy(lamp_direction({ ...light, lamp: { ...light.lamp, around_deg: around, height_deg: height } }).multiplyScalar(40));
        panel.lookAt(0, 0, 0);
        scene.add(panel);
      }
      const generator = new THREE.PMREMGenerator(this.renderer);
      target = generator.fromScene(scene, 0.02, 1, 100);
      generator.dispose();
      scene.traverse((o) => { if (o instanceof THREE.Mesh) { (o.geometry as THREE.BufferGeometry).dispose(); (o.material as THREE.Material).dispose(); } });
      this.made.set(light.name, target);
    }
    return target.texture;
  }

  dispose(): void {
    for (const target of this.made.values()) target.dispose();
    this.made.clear();
  }
}
