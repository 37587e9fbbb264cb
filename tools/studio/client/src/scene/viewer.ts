// One canvas with a scene, a camera that turns (or, for flat pictures, shifts), light and picking. Draws only when something changed.
import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { current_theme, on_theme } from "../ui/theme";
import { Environments, kLights, lamp_direction, surroundings_of_picture, type Lamp, type RadianceMap } from "./environment";
import { distance_to_fit } from "./framing";
import { Lighting } from "./lighting";
import { first_hit, prepare_picking, type Hit } from "./picking";

export type { Hit };

const kShadowTexels = 2048;
const kClick_px = 5;
const kLook_ms = 4, kPrepare_ms = 250;
const kRays = 3;  // Along each side of a pixel of a picture that is saved.
const kSlow_ms = 45, kLeastScale = 0.5, kRest_ms = 350;

export class Viewer {
  readonly scene = new THREE.Scene();
  readonly renderer: THREE.WebGLRenderer;
  readonly canvas: HTMLCanvasElement;
  readonly controls: OrbitControls;
  camera: THREE.PerspectiveCamera | THREE.OrthographicCamera;
  /// What fit() looks at and clicks hit.
  readonly content = new THREE.Group();
  /// Of lit_material().
  readonly lighting = new Lighting();
  /// Called before a frame is drawn, and after.
  before_frame: (() => void) | undefined;
  after_frame: (() => void) | undefined;
  on_click: ((hit: Hit | undefined, event: PointerEvent) => void) | undefined;
  on_resize: (() => void) | undefined;
  num_frames = 0;
  /// Of fit(), times the least distance.
  margin = 1.06;

  private keeps_moving = false;
  private readonly lamp = new THREE.DirectionalLight(0xffffff, 1);
  private readonly floor: THREE.Mesh;
  readonly environments: Environments;
  private readonly observer: ResizeObserver;
  private readonly stop_theme: () => void;
  private readonly is_software: boolean;
  private is_asked = false;
  private is_fit_due = false;
  private is_drawing = false;
  private is_disposed = false;
  private scale = 1;
  private next_scale = 1;
  private is_rest_frame = false;
  private rest_timer: number | undefined;
  private shining: Lamp | undefined;
  private light_turn_deg = 0;
  private light = kLights[0]!.name;
  private are_surroundings_shown = false;
  private readonly raycaster = new THREE.Raycaster();
  private down: { x: number; y: number } | undefined;

  constructor(readonly element: HTMLElement, readonly is_flat: boolean) {
    this.is_software = draws_in_software();
    this.renderer = new THREE.WebGLRenderer({ antialias: !this.is_software, powerPreference: "high-performance" });
    this.renderer.toneMapping = THREE.NoToneMapping;  // As `render`: radiance 1 is white.
    this.renderer.shadowMap.enabled = !is_flat;
    this.renderer.shadowMap.type = this.is_software ? THREE.BasicShadowMap : THREE.PCFSoftShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    element.prepend(this.canvas);
    this.camera = is_flat ? new THREE.OrthographicCamera(-1, 1, 1, -1, -1000, 1000) : new THREE.PerspectiveCamera(32, 1, 0.01, 1000);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener("change", () => this.invalidate());
    this.controls.zoomToCursor = true;
    if (is_flat) {
      this.controls.enableRotate = false;
      this.controls.screenSpacePanning = true;
      this.controls.mouseButtons = { LEFT: THREE.MOUSE.PAN, MIDDLE: THREE.MOUSE.DOLLY, RIGHT: THREE.MOUSE.PAN };
      this.controls.touches = { ONE: THREE.TOUCH.PAN, TWO: THREE.TOUCH.DOLLY_PAN };
    }
    this.floor = new THREE.Mesh(new THREE.CircleGeometry(1, 96), new THREE.ShadowMaterial({ opacity: 0.32 }));
    this.floor.rotation.x = -Math.PI / 2;
    this.floor.receiveShadow = true;
    this.floor.visible = !is_flat;
    this.lamp.castShadow = true;
    this.lamp.shadow.mapSize.set(kShadowTexels, kShadowTexels);
    this.lamp.shadow.bias = -0.0005;
    this.lamp.shadow.normalBias = 0.02;
    this.scene.add(this.content, this.floor);
    if (!is_flat) this.scene.add(this.lamp, this.lamp.target);
    this.environments = new Environments(this.renderer);
    this.canvas.addEventListener("pointerdown", (e) => { this.down = e.button === 0 && e.isPrimary ? { x: e.clientX, y: e.clientY } : undefined; });
    this.canvas.addEventListener("pointerup", (e) => this.release(e));
    this.canvas.addEventListener("webglcontextlost", (e) => e.preventDefault());
    this.canvas.addEventListener("webglcontextrestored", () => this.invalidate());
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(element);
    this.stop_theme = on_theme(() => this.show_background());
    this.show_background();
    this.set_light("studio");
    this.resize();
  }

  /// A frame is drawn soon; one at a time, so that a slow machine skips frames and never queues them.
  invalidate(): void {
    if (this.is_asked) return;
    this.is_asked = true;
    if (!this.is_drawing) requestAnimationFrame(() => this.draw());
  }

  /// While pictures keep coming, however slowly, none of them is drawn once more with all pixels.
  set_moving(keeps_moving: boolean): void {
    if (this.keeps_moving && !keeps_moving) this.invalidate();
    this.keeps_moving = keeps_moving;
  }

  /// Everything that was asked for is on screen, with all pixels.
  get is_at_rest(): boolean {
    return !this.is_asked && !this.is_drawing && this.scale === this.full_scale;
  }

  // Multisampling costs four times as much in software: there, pictures at rest have more pixels instead.
  private get full_scale(): number {
    return this.is_software ? 1.5 : 1;
  }

  /// Objects or light have moved: shadows are drawn again.
  invalidate_shadows(): void {
    this.renderer.shadowMap.needsUpdate = true;
    this.invalidate();
  }

  bounds(): THREE.Box3 {
    return new THREE.Box3().setFromObject(this.content);
  }

  /// After the content has come: the first look at it costs nothing then.
  content_has_come(): void {
    window.setTimeout(() => { if (!this.is_disposed) prepare_picking(this.content); }, kPrepare_ms);
  }

  /// The whole content in view. @param toward  Where the camera stands, seen from the content.
  fit(toward = new THREE.Vector3(0.55, 0.32, 1)): void {
    const box = this.bounds();
    if (box.isEmpty()) return;
    this.is_fit_due = this.canvas.clientWidth === 0;  // Not on the page yet.
    if (this.is_fit_due) return;
    const center = box.getCenter(new THREE.Vector3());
    const size = box.getSize(new THREE.Vector3());
    const aspect = this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight);
    if (this.camera instanceof THREE.OrthographicCamera) {
      this.camera.zoom = Math.min(2 / (size.y * 1.06), (2 * aspect) / (size.x * 1.06));
      this.camera.position.set(center.x, center.y, 10);
      this.controls.minZoom = this.camera.zoom / 4;
    } else {
      const way = toward.clone().normalize();
      const distance = this.margin * distance_to_fit(box, way, this.camera.fov, aspect);
      this.camera.position.copy(center).addScaledVector(way, distance);
      this.camera.near = distance / 200;
      this.camera.far = distance * 40;
      this.controls.minDistance = size.length() / 50;
      this.controls.maxDistance = distance * 8;
    }
    this.controls.target.copy(center);
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.place_lamp();
    this.invalidate_shadows();
  }

  /// @param name  Of kLights, or of a picture that was added to `environments`.
  set_light(name: string, turn_deg = this.light_turn_deg): void {
    this.light_turn_deg = turn_deg;
    this.light = name;
    const { surroundings, mirror } = this.environments.get(name);
    if (!this.is_flat) {
      this.scene.environment = mirror;
      this.scene.environmentRotation.y = (turn_deg * Math.PI) / 180;
    }
    const { lamp, smooth, even } = surroundings;
    this.shining = lamp;
    this.lighting.set(smooth, lamp?.half_angle_deg ?? 0, lamp?.is_around === false, even);
    this.lamp.color.setRGB(...(lamp?.color ?? [0, 0, 0]));
    this.lamp.intensity = Math.PI;
    this.place_lamp();
    this.show_background();
    this.invalidate_shadows();
  }

  /// Light from a picture, by its file's name. @param map  Rows from the top. @throws Error where it is black
  add_light(name: string, map: RadianceMap): void {
    this.environments.add(name, surroundings_of_picture(map));
  }

  /// What gives light as the background, too.
  show_surroundings(are_shown: boolean): void {
    this.are_surroundings_shown = are_shown;
    this.show_background();
  }

  /// Options of `render` for this light; none where it has no such light. @param azimuth  Of its camera, degrees.
  light_options(azimuth: number): Record<string, string> {
    const { light, shining, light_turn_deg: turn } = this;
    const degrees = (angle: number): string => String(Number((((((angle + 180) % 360) + 360) % 360) - 180).toFixed(2)));
    if (light === kLights[0]!.name) return { light_azimuth: degrees((shining?.around_deg ?? 0) + turn - azimuth) };
    if (kLights.some(({ name }) => name === light)) return {};
    return { environment: light, environment_azimuth: degrees(turn - azimuth), ...(this.are_surroundings_shown ? { backdrop: "environment" } : {}) };
  }

  /// What is on screen as a PNG of another size, without what is not of the scene. Each pixel is the mean of several.
  async picture(width: number, height: number): Promise<Blob> {
    const { renderer, camera, scene } = this, most = renderer.capabilities.maxTextureSize;
    const rays = Math.max(1, Math.min(kRays, Math.floor(most / Math.max(width, height))));
    const eye = camera.clone() as typeof camera;
    if (eye instanceof THREE.PerspectiveCamera) eye.aspect = width / height;
    else [eye.left, eye.right] = [-width / height, width / height];
    eye.updateProjectionMatrix();
    const hidden = scene.children.filter((child) => child.visible && child !== this.content && child !== this.floor && child !== this.lamp);
    for (const child of hidden) child.visible = false;
    try {
      this.before_frame?.();
      renderer.setPixelRatio(1);
      renderer.setSize(width * rays, height * rays, false);
      renderer.render(scene, eye);
      const small = document.createElement("canvas"), context = small.getContext("2d");
      [small.width, small.height] = [width, height];
      if (!context) throw new Error("there is no memory for a picture of this size");
      context.imageSmoothingQuality = "high";
      context.drawImage(renderer.domElement, 0, 0, width, height);
      const file = await new Promise<Blob | null>((resolve) => small.toBlob(resolve, "image/png"));
      if (!file) throw new Error("there is no memory for a picture of this size");
      return file;
    } finally {
      for (const child of hidden) child.visible = true;
      this.set_scale(this.scale);
      this.invalidate();
    }
  }

  set_shadows(are_on: boolean): void {
    this.lamp.castShadow = are_on;
    this.floor.visible = are_on && !this.is_flat;
    this.invalidate_shadows();
  }

  /// What lies under a point of the window, in `content`.
  pick(client_x: number, client_y: number): Hit | undefined {
    return first_hit(this.aim(client_x, client_y), this.content);
  }

  /// A ray through a point of the window.
  aim(client_x: number, client_y: number): THREE.Ray {
    const box = this.canvas.getBoundingClientRect();
    this.camera.updateMatrixWorld();  // It may have moved since the last frame, and there may be none yet.
    this.content.updateMatrixWorld();
    this.raycaster.setFromCamera(new THREE.Vector2((2 * (client_x - box.left)) / box.width - 1, 1 - (2 * (client_y - box.top)) / box.height), this.camera);
    return this.raycaster.ray;
  }

  /// Where a point of the scene is in the window.
  project(point: THREE.Vector3): { x: number; y: number } {
    const box = this.canvas.getBoundingClientRect();
    this.camera.updateMatrixWorld();
    const p = point.clone().project(this.camera);
    return { x: box.left + ((p.x + 1) / 2) * box.width, y: box.top + ((1 - p.y) / 2) * box.height };
  }

  /// How much a pixel is at a point of the scene.
  mm_per_px(point = this.controls.target): number {
    const { camera } = this;
    const height = camera instanceof THREE.OrthographicCamera ? 2 / camera.zoom : 2 * camera.position.distanceTo(point) * Math.tan((camera.fov * Math.PI) / 360);
    return height / Math.max(1, this.canvas.clientHeight);
  }

  dispose(): void {
    this.is_disposed = true;
    window.clearTimeout(this.rest_timer);
    this.observer.disconnect();
    this.stop_theme();
    this.controls.dispose();
    this.environments.dispose();
    this.scene.traverse((o) => {
      if (o instanceof THREE.Mesh || o instanceof THREE.Points || o instanceof THREE.Line) (o.geometry as THREE.BufferGeometry).dispose();
    });
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.canvas.remove();
  }

  private draw(): void {
    this.is_asked = false;
    if (this.is_disposed) return;
    const scale = this.is_rest_frame ? this.full_scale : this.next_scale;
    if (scale !== this.scale) this.set_scale(scale);
    this.before_frame?.();
    const begin = performance.now();
    this.renderer.render(this.scene, this.camera);
    ++this.num_frames;
    this.is_drawing = true;
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const look = (): void => {
      if (this.is_disposed) return;
      if (fence && !gl.isContextLost() && gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) {
        window.setTimeout(look, kLook_ms);
        return;
      }
      if (fence) gl.deleteSync(fence);
      this.is_drawing = false;
      this.after_frame?.();
      this.adapt(performance.now() - begin);
      if (this.is_asked) requestAnimationFrame(() => this.draw());
    };
    window.setTimeout(look, 0);
  }

  // Where frames take long, as in software, the next ones have fewer pixels while the picture moves; all of them once it is at rest.
  private adapt(cost_ms: number): void {
    window.clearTimeout(this.rest_timer);
    if (this.is_rest_frame) {
      this.is_rest_frame = false;
      return;
    }
    if (cost_ms > kSlow_ms) this.next_scale = Math.max(kLeastScale, 0.75 * this.next_scale);
    if (this.scale === this.full_scale || this.keeps_moving) return;
    this.rest_timer = window.setTimeout(() => {
      this.is_rest_frame = this.scale !== this.full_scale;
      if (this.is_rest_frame) this.invalidate();
    }, kRest_ms);
  }

  private set_scale(scale: number): void {
    this.scale = scale;
    const { clientWidth: width, clientHeight: height } = this.element;
    this.renderer.setPixelRatio(scale * Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height);
    this.on_resize?.();
  }

  private release(event: PointerEvent): void {
    if (!this.down || Math.hypot(event.clientX - this.down.x, event.clientY - this.down.y) > kClick_px) return;
    this.down = undefined;
    this.on_click?.(this.pick(event.clientX, event.clientY), event);
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (width === 0 || height === 0) return;
    this.set_scale(this.scale);
    if (this.camera instanceof THREE.OrthographicCamera) [this.camera.left, this.camera.right] = [-width / height, width / height];
    else this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.is_fit_due) this.fit();
    this.invalidate();
  }

  private place_lamp(): void {
    const box = this.bounds();
    if (box.isEmpty()) return;
    const sphere = box.getBoundingSphere(new THREE.Sphere());
    const r = sphere.radius;
    this.lamp.target.position.copy(sphere.center);
    this.lamp.position.copy(sphere.center).addScaledVector(this.shining ? lamp_direction(this.shining, this.light_turn_deg) : new THREE.Vector3(0, 1, 0), 3 * r);
    const camera = this.lamp.shadow.camera;
    [camera.left, camera.right, camera.bottom, camera.top, camera.near, camera.far] = [-1.3 * r, 1.3 * r, -1.3 * r, 1.3 * r, 0.5 * r, 6 * r];
    camera.updateProjectionMatrix();
    this.lamp.shadow.normalBias = r / 700;
    this.floor.position.set(sphere.center.x, box.min.y - 0.002 * r, sphere.center.z);
    this.floor.scale.setScalar(3 * r);
  }

  private show_background(): void {
    const picture = this.are_surroundings_shown && !this.is_flat ? this.environments.get(this.light).picture : undefined;
    this.scene.background = picture ?? new THREE.Color(current_theme() === "dark" ? 0x1b1d1f : 0xe9e6e0);
    this.scene.backgroundRotation.copy(this.scene.environmentRotation);
    this.invalidate();
  }
}

/// Whether the browser has no graphics card: asked once, of a canvas of its own.
function draws_in_software(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = gl && info ? String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}
