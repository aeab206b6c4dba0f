// The line in three dimensions. Drawn when something changed, not all the time.

import { useEffect, useRef, useState } from "preact/hooks";
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { grade } from "./marks";
import { store, type Known } from "./store";
import { t } from "./text";
import { colour } from "./use";
import type { Point } from "./types";
import type { Shown } from "./Drawing";

const VIEWS: Record<string, Point> = { three: [-0.55, -1, 0.42], side: [0, -1, 0.001], top: [0, 0.001, 1], rear: [1, 0, 0.05] };

/** The page's x, right, up as three has them: x, up, towards the reader. */
const put = (p: Point): THREE.Vector3 => new THREE.Vector3(p[0], p[2], -p[1]);

interface Stage {
  renderer: THREE.WebGLRenderer;
  scene: THREE.Scene;
  camera: THREE.PerspectiveCamera;
  controls: OrbitControls;
  line: THREE.Group;
  draw: () => void;
}

export default function Scene({ known, shown }: { known: Known; shown: Shown }) {
  const box = useRef<HTMLDivElement>(null);
  const stage = useRef<Stage | null>(null);
  const [missing, miss] = useState(false);

  useEffect(() => {
    const element = box.current;
    if (!element) return undefined;
    let renderer: THREE.WebGLRenderer;
    try {
      renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    } catch {
      miss(true);
      return undefined;
    }
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    renderer.domElement.setAttribute("role", "img");
    renderer.domElement.setAttribute("aria-label", t("The line in three dimensions"));
    element.append(renderer.domElement);
    const scene = new THREE.Scene();
    scene.add(new THREE.HemisphereLight(0xffffff, 0x8896a8, 2.2));
    const sun = new THREE.DirectionalLight(0xffffff, 1.6);
    sun.position.set(-2, 5, 3);
    scene.add(sun);
    const camera = new THREE.PerspectiveCamera(30, 2, 10, 60000);
    const controls = new OrbitControls(camera, renderer.domElement);
    const line = new THREE.Group();
    scene.add(line);
    const draw = (): void => renderer.render(scene, camera);
    controls.addEventListener("change", draw);
    stage.current = { renderer, scene, camera, controls, line, draw };
    const size = (): void => {
      const [w, h] = [element.clientWidth || 600, element.clientHeight || 360];
      renderer.setSize(w, h);
      camera.aspect = w / h;
      camera.updateProjectionMatrix();
      draw();
    };
    const watcher = new ResizeObserver(size);
    watcher.observe(element);
    size();
    build(stage.current, shown);
    look(stage.current, shown, VIEWS.three as Point);
    return () => {
      watcher.disconnect();
      controls.dispose();
      renderer.dispose();
      renderer.domElement.remove();
      stage.current = null;
    };
  }, [shown.line.name]);

  useEffect(() => {
    if (stage.current) build(stage.current, shown);
  }, [known.live, known.full, shown.laid, shown.state, known.theme]);

  return (
    <figure class="view scene3">
      <div class="chips" role="group" aria-label={t("Look from")}>
        {([["three", t("aside")], ["side", t("the left")], ["top", t("above")], ["rear", t("the rear")]] as const).map(([key, name]) => (
          <button key={key} onClick={() => stage.current && look(stage.current, shown, VIEWS[key] as Point)}>{name}</button>
        ))}
      </div>
      {missing ? <p class="note">{t("This browser draws nothing in three dimensions.")}</p> : <div class="canvas" ref={box} />}
    </figure>
  );
}

const css = (name: string): THREE.Color => new THREE.Color(colour(name));

function build(s: Stage, shown: Shown): void {
  for (const child of [...s.line.children]) {
    s.line.remove(child);
    if (child instanceof THREE.Mesh) child.geometry.dispose();
  }
  const rows = store.rows();
  const { line, laid, state } = shown;
  const skin = (name: string, opacity = 1): THREE.MeshStandardMaterial =>
    new THREE.MeshStandardMaterial({ color: css(name), roughness: 0.55, metalness: 0.15, transparent: opacity < 1, opacity });
  const graded = (kind: string, n: number, plain: string): string => {
    const found = grade(rows, line.name, state, kind, n);
    return found === "fail" ? "--fail" : found === "warn" ? "--warn" : plain;
  };
  const rod = (a: Point, b: Point, radius: number, material: THREE.Material): void => {
    const [from, to] = [put(a), put(b)];
    const way = to.clone().sub(from);
    const mesh = new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, way.length(), 28), material);
    mesh.position.copy(from).addScaledVector(way, 0.5);
    mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), way.normalize());
    s.line.add(mesh);
  };
  const ball = (at: Point, radius: number, material: THREE.Material): void => {
    const mesh = new THREE.Mesh(new THREE.SphereGeometry(radius, 28, 18), material);
    mesh.position.copy(put(at));
    s.line.add(mesh);
  };
  const all = [laid.ends[0], ...laid.joints, laid.ends[1]];
  all.slice(0, -1).forEach((a, k) => {
    const tube = k > 0 && k < all.length - 2;
    rod(a, all[k + 1] as Point, (tube ? (line.tubes[k - 1] ?? 60) : 70) / 2, skin(tube ? graded("shaft", k, "--tube") : "--faint"));
  });
  laid.joints.forEach((p, k) => ball(p, 0.72 * Math.max(80, ...line.tubes.map((d) => d ?? 0)), skin(graded("joint", k + 1, "--ink"))));
  laid.bearings.forEach((p, k) => {
    const along = put(laid.joints[k + 1] as Point).sub(put(laid.joints[k] as Point)).normalize();
    const ring = new THREE.Mesh(new THREE.TorusGeometry(0.75 * (line.tubes[k] ?? 100), 22, 14, 40), skin(graded("centre bearing", k + 1, "--accent")));
    ring.position.copy(put(p));
    ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), along);
    s.line.add(ring);
  });
  for (const number of line.obstacles) {
    const o = shown.live.obstacles[number];
    if (!o) continue;
    const up = o.share * (line.travel[state] ?? 0);
    const [a, b] = [o.start, o.end].map((p) => [p[0], p[1], p[2] + up] as Point) as [Point, Point];
    const material = skin("--obstacle", 0.75);
    ball(a, o.radius, material);
    if (Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]) > 1) {
      rod(a, b, o.radius, material);
      ball(b, o.radius, material);
    }
  }
  s.draw();
}

function look(s: Stage, shown: Shown, from: Point): void {
  const sphere = new THREE.Box3().setFromPoints([...shown.laid.joints, ...shown.laid.ends].map(put)).getBoundingSphere(new THREE.Sphere());
  const across = Math.min(1, s.camera.aspect);
  const far = sphere.radius / Math.sin((s.camera.fov * Math.PI) / 360) / Math.max(across, 0.4) * (s.camera.aspect > 1.6 ? 0.66 : 1.02);
  s.controls.target.copy(sphere.center);
  s.camera.position.copy(sphere.center).addScaledVector(put(from).normalize(), far);
  s.camera.far = far * 6;
  s.camera.updateProjectionMatrix();
  s.controls.update();
  s.draw();
}
