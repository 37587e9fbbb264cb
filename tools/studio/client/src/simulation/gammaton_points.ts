// Gammatons under way, as points.
import * as THREE from "three";

export class GammatonPoints {
  private readonly points: THREE.Points;

  constructor(scene: THREE.Scene) {
    this.points = new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({ color: 0x8fc7ff, size: 2.2, sizeAttenuation: false, transparent: true, opacity: 0.8, depthWrite: false }));
    this.points.frustumCulled = false;
    scene.add(this.points);
  }

  /// xyz, mm. Empty: none are shown.
  show(positions: Float32Array): void {
    const attribute = this.points.geometry.getAttribute("position") as THREE.BufferAttribute | undefined;
    if (attribute && attribute.array.length >= positions.length) {
      (attribute.array as Float32Array).set(positions);
      attribute.needsUpdate = true;
    } else {
      this.points.geometry.dispose();
      this.points.geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(positions.slice(), 3));
    }
    this.points.geometry.setDrawRange(0, positions.length / 3);
    this.points.visible = positions.length > 0;
  }

  dispose(): void {
    this.points.geometry.dispose();
  }
}
