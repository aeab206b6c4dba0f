// Something in three dimensions to turn about. Drawn when it changed, not all the time.

import { useEffect, useRef, useState } from "preact/hooks";
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { cssColour } from "./hooks";
import type { Point } from "./types";

/** The page's x, right, up as three has them: x, up, towards the reader. */
export const toSceneAxes = (p: Point): THREE.Vector3 => new THREE.Vector3(p[0], p[2], -p[1]);

export const surfaceMaterial = (name: string, opacity = 1): THREE.MeshStandardMaterial =>
  new THREE.MeshStandardMaterial({ color: new THREE.Color(cssColour(name)), roughness: 0.55, metalness: 0.15, transparent: opacity < 1, opacity });

export class Scene3d {
  readonly renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(30, 2, 10, 60000);
  readonly controls = new OrbitControls(this.camera, this.renderer.domElement);
  readonly group = new THREE.Group();
  /** Told of each drawing. */
  drawn: (s: Scene3d) => void = () => undefined;

  constructor(readonly box: HTMLElement, label: string) {
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.domElement.setAttribute("role", "img");
    this.renderer.domElement.setAttribute("aria-label", label);
    box.append(this.renderer.domElement);
    const sun = new THREE.DirectionalLight(0xffffff, 1.6);
    sun.position.set(-2, 5, 3);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8896a8, 2.2), sun, this.group);
    this.controls.addEventListener("change", this.draw);
  }

  draw = (): void => {
    this.renderer.render(this.scene, this.camera);
    this.drawn(this);
  };

  private seen: THREE.Vector3[] = [];

  /** Where what is looked at has its middle, beside the target, and from how far off all of it is in sight. */
  private frame(): { aside: THREE.Vector3; far: number } {
    const { camera: c, controls } = this;
    const up = Math.tan((c.fov * Math.PI) / 360) / 1.12;
    const at = this.seen.map((p) => p.clone().sub(controls.target).applyQuaternion(c.quaternion.clone().invert()));
    const reach = (of: "x" | "y", by: number): number => Math.max(...at.map((q) => q[of] / by + q.z), 1);
    const [right, left, top, foot] = [reach("x", up * c.aspect), reach("x", -up * c.aspect), reach("y", up), reach("y", -up)];
    const aside = new THREE.Vector3(up * c.aspect * (right - left), up * (top - foot), 0).divideScalar(2);
    return { aside: aside.applyQuaternion(c.quaternion), far: Math.max(right + left, top + foot) / 2 };
  }

  /** Look beside the target, from as many times as far off. */
  private step(times: number, aside: THREE.Vector3): void {
    const { camera: c, controls } = this;
    c.position.sub(controls.target).multiplyScalar(times).add(controls.target.add(aside));
    const far = c.position.distanceTo(controls.target);
    [c.near, c.far] = [far / 100, far * 6];
    c.updateProjectionMatrix();
    controls.update();
    this.draw();
  }

  size = (): void => {
    const [w, h, was] = [this.box.clientWidth || 600, this.box.clientHeight || 360, this.frame()];
    this.renderer.setSize(w, h);
    this.camera.aspect = w / h;
    const now = this.frame();
    this.step(now.far / was.far, now.aside.sub(was.aside)); // as near as a hand had gone
  };

  clear(): void {
    for (const child of [...this.group.children]) {
      this.group.remove(child);
      if (child instanceof THREE.Mesh) child.geometry.dispose();
    }
  }

  look(points: Point[], from: Point): void {
    const { camera: c, controls } = this;
    this.seen = points.map(toSceneAxes);
    new THREE.Box3().setFromPoints(this.seen).getCenter(controls.target);
    c.position.copy(controls.target).add(toSceneAxes(from).normalize());
    c.lookAt(controls.target);
    const { aside, far } = this.frame();
    this.step(far, aside);
  }

  end(): void {
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.domElement.remove();
  }
}

/** A stage in an element; `made` is told of it once. `missing` where a browser draws nothing so. */
export function useScene3d(label: string, made: (s: Scene3d) => void, of: unknown[]) {
  const box = useRef<HTMLDivElement>(null);
  const stage = useRef<Scene3d | null>(null);
  const [missing, miss] = useState(false);
  useEffect(() => {
    if (!box.current) return undefined;
    let s: Scene3d;
    try {
      s = new Scene3d(box.current, label);
    } catch {
      miss(true);
      return undefined;
    }
    stage.current = s;
    const watcher = new ResizeObserver(s.size);
    watcher.observe(box.current);
    s.size();
    made(s);
    return () => {
      watcher.disconnect();
      s.end();
      stage.current = null;
    };
  }, of);
  return { box, stage, missing };
}
