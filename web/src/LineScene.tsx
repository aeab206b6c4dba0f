// The line in three dimensions.

import { useEffect } from "preact/hooks";
import * as THREE from "three";
import type { ShownLine } from "./Drawing";
import { toSceneAxes, surfaceMaterial, useScene3d, type Scene3d } from "./scene3d";
import type { AppState } from "./store";
import { t } from "./i18n";
import type { Point } from "./types";

const VIEWS: Record<string, Point> = { three: [-0.55, -1, 0.42], side: [0, -1, 0.001], top: [0, 0.001, 1], rear: [1, 0, 0.05] };

export default function LineScene({ known, shown }: { known: AppState; shown: ShownLine }) {
  const points = [...shown.laid.joints, ...shown.laid.ends];
  const { box, stage, missing } = useScene3d(t("The line in three dimensions"), (s) => { build(s, shown); s.look(points, VIEWS.three as Point); }, [shown.line.name]);

  useEffect(() => { if (stage.current) build(stage.current, shown); }, [known.live, known.full, shown.laid, shown.state, known.theme]);

  return (
    <figure class="view scene3">
      <div class="chips" role="group" aria-label={t("Look from")}>
        {([["three", t("oblique view")], ["side", t("the left")], ["top", t("above")], ["rear", t("the rear")]] as const).map(([key, name]) => (
          <button key={key} onClick={() => stage.current?.look(points, VIEWS[key] as Point)}>{name}</button>
        ))}
      </div>
      {missing ? <p class="note">{t("This browser has no 3-D graphics.")}</p> : <div class="canvas" ref={box} />}
    </figure>
  );
}

function build(s: Scene3d, shown: ShownLine): void {
  s.clear();
  const { line, laid, state } = shown;
  const graded = (kind: string, n: number, plain: string): string => {
    const found = shown.marks[`${kind} ${n}`];
    return found === "fail" ? "--fail" : found === "warn" ? "--warn" : plain;
  };
  const rod = (a: Point, b: Point, radius: number, material: THREE.Material): void => {
    const [from, to] = [toSceneAxes(a), toSceneAxes(b)];
    const way = to.clone().sub(from);
    const mesh = new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, way.length(), 28), material);
    mesh.position.copy(from).addScaledVector(way, 0.5);
    mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), way.normalize());
    s.group.add(mesh);
  };
  const ball = (at: Point, radius: number, material: THREE.Material): void => {
    const mesh = new THREE.Mesh(new THREE.SphereGeometry(radius, 28, 18), material);
    mesh.position.copy(toSceneAxes(at));
    s.group.add(mesh);
  };
  /** A bar of a rectangular section between two points; `across` is where its first side points. */
  const bar = (from: THREE.Vector3, to: THREE.Vector3, [wide, high]: [number, number], material: THREE.Material, across?: THREE.Vector3): void => {
    const way = to.clone().sub(from);
    const mesh = new THREE.Mesh(new THREE.BoxGeometry(wide, way.length(), high), material);
    mesh.position.copy(from).addScaledVector(way, 0.5);
    const along = way.clone().normalize();
    if (across) mesh.quaternion.setFromRotationMatrix(new THREE.Matrix4().makeBasis(across, along, across.clone().cross(along)));
    else mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along);
    s.group.add(mesh);
  };
  /** A yoke: two ears on the ends of a pin, and what joins them on the member's axis. */
  const yoke = (at: THREE.Vector3, along: THREE.Vector3, pin: THREE.Vector3, wide: number, material: THREE.Material): void => {
    const spot = (a: number, b: number): THREE.Vector3 => at.clone().addScaledVector(along, a * wide).addScaledVector(pin, b * wide);
    for (const side of [-0.55, 0.55]) bar(spot(-0.22, side), spot(0.95, side), [0.16 * wide, 0.5 * wide], material, pin);
    bar(spot(0.8, 0), spot(1.05, 0), [1.26 * wide, 0.62 * wide], material, pin);
  };
  const all = [laid.ends[0], ...laid.joints, laid.ends[1]];
  const size = Math.max(80, ...line.tubes.map((d) => d ?? 0));
  all.slice(0, -1).forEach((a, k) => {
    const tube = k > 0 && k < all.length - 2;
    const b = all[k + 1] as Point;
    // A tube ends at its yokes.
    const share = (at: number): number => (laid.pins[at]?.length ? Math.min(0.9 * size / Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]), 0.45) : 0);
    const between = (u: number): Point => [a[0] + u * (b[0] - a[0]), a[1] + u * (b[1] - a[1]), a[2] + u * (b[2] - a[2])];
    rod(between(share(k - 1)), between(1 - share(k)), (tube ? (line.tubes[k - 1] ?? 60) : 70) / 2, surfaceMaterial(tube ? graded("shaft", k, "--tube") : "--faint"));
  });
  laid.joints.forEach((p, k) => {
    const [driving, driven] = (laid.pins[k] ?? []).map(toSceneAxes);
    const material = surfaceMaterial(graded("joint", k + 1, "--faint"));
    if (!driving || !driven) return ball(p, 0.72 * size, material); // a joint without a cross
    const at = toSceneAxes(p);
    const away = (to: Point): THREE.Vector3 => toSceneAxes(to).sub(at).normalize();
    [driving, driven].forEach((pin) => bar(at.clone().addScaledVector(pin, -0.62 * size), at.clone().addScaledVector(pin, 0.62 * size), [0.2 * size, 0.2 * size], surfaceMaterial("--series-1")));
    yoke(at, away(all[k] as Point), driving, size, material);
    yoke(at, away(all[k + 2] as Point), driven, size, material);
  });
  laid.bearings.forEach((p, k) => {
    const along = toSceneAxes(laid.joints[k + 1] as Point).sub(toSceneAxes(laid.joints[k] as Point)).normalize();
    const ring = new THREE.Mesh(new THREE.TorusGeometry(0.75 * (line.tubes[k] ?? 100), 22, 14, 40), surfaceMaterial(graded("centre bearing", k + 1, "--accent")));
    ring.position.copy(toSceneAxes(p));
    ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), along);
    s.group.add(ring);
  });
  for (const number of line.obstacles) {
    const o = shown.live.obstacles[number];
    if (!o) continue;
    const up = o.share * (line.travel[state] ?? 0);
    const [a, b] = [o.start, o.end].map((p) => [p[0], p[1], p[2] + up] as Point) as [Point, Point];
    const material = surfaceMaterial("--obstacle", 0.75);
    ball(a, o.radius, material);
    if (Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]) > 1) {
      rod(a, b, o.radius, material);
      ball(b, o.radius, material);
    }
  }
  s.draw();
}
