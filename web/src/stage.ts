// Something in three dimensions to turn about. Drawn when it changed, not all the time.

import { useEffect, useRef, useState } from "preact/hooks";
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { colour } from "./use";
import type { Point } from "./types";

/** The page's x, right, up as three has them: x, up, towards the reader. */
export const put = (p: Point): THREE.Vector3 => new THREE.Vector3(p[0], p[2], -p[1]);

export const skin = (name: string, opacity = 1): THREE.MeshStandardMaterial =>
  new THREE.MeshStandardMaterial({ color: new THREE.Color(colour(name)), roughness: 0.55, metalness: 0.15, transparent: opacity < 1, opacity });

export class Stage {
  readonly renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(30, 2, 10, 60000);
  readonly controls = new OrbitControls(this.camera, this.renderer.domElement);
  readonly group = new THREE.Group();
  /** Told of each drawing. */
  drawn: (s: Stage) => void = () => undefined;

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

  size = (): void => {
    const [w, h] = [this.box.clientWidth || 600, this.box.clientHeight || 360];
    this.renderer.setSize(w, h);
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    this.draw();
  };

  clear(): void {
    for (const child of [...this.group.children]) {
      this.group.remove(child);
      if (child instanceof THREE.Mesh) child.geometry.dispose();
    }
  }

  look(points: Point[], from: Point): void {
    const sphere = new THREE.Box3().setFromPoints(points.map(put)).getBoundingSphere(new THREE.Sphere());
    const { camera: c } = this;
    const far = (sphere.radius / Math.sin((c.fov * Math.PI) / 360) / Math.max(Math.min(1, c.aspect), 0.4)) * (c.aspect > 1.6 ? 0.66 : 1.02);
    this.controls.target.copy(sphere.center);
    c.position.copy(sphere.center).addScaledVector(put(from).normalize(), far);
    [c.near, c.far] = [far / 100, far * 6];
    c.updateProjectionMatrix();
    this.controls.update();
    this.draw();
  }

  end(): void {
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.domElement.remove();
  }
}

/** A stage in an element; `made` is told of it once. `missing` where a browser draws nothing so. */
export function useStage(label: string, made: (s: Stage) => void, of: unknown[]) {
  const box = useRef<HTMLDivElement>(null);
  const stage = useRef<Stage | null>(null);
  const [missing, miss] = useState(false);
  useEffect(() => {
    if (!box.current) return undefined;
    let s: Stage;
    try {
      s = new Stage(box.current, label);
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
