// The bracket under its loads: stress as colour, deformation, the places where a crack may start.

import { useEffect, useState } from "preact/hooks";
import * as THREE from "three";
import { ReportBlocks } from "./Blocks";
import { Card } from "./Card";
import { formatFixed, formatNumber, marginText } from "./format";
import { toSceneAxes, surfaceMaterial, useScene3d, type Scene3d } from "./scene3d";
import { store, type Job, type AppState } from "./store";
import { t } from "./i18n";
import { gradeText, verdictText } from "./gradeLookup";
import type { Point, Seated } from "./types";
import { JobButton } from "./SpeedView";

type Variant = Seated["variants"][number];
type Case = Variant["cases"][number];

export default function Bracket({ known }: { known: AppState }) {
  const job = known.jobs.bracket as Job<Seated> | undefined;
  const of = job?.answer;
  return (
    <>
      <Card id="bracket" title={t("The bracket")} head={<><JobButton job={job} name="bracket" word={t("compute")} stale={job?.of !== store.about({})} ask={() => store.work("bracket")} />{of && <b class={of.verdict}>{verdictText(of.verdict)}</b>}</>}>
        {!of && known.missing.some((m) => m.extra === "bracket") && <p class="note warn">{t("The bracket cannot be solved yet: pip install 'cardan[bracket]', then start again")}</p>}
        {!of && <p class="note">{t("Finite elements under the loads of every state: some minutes. Its shape: bracket in the file.")}</p>}
        {!of && known.history && !/^bracket:/m.test(known.history.text) && <ExampleBracket known={known} text={known.history.text} />}
        {of && <ul class="others">{of.checks.map((c) => <li key={c.quantity + c.where}><b class={c.grade}>{gradeText(c.grade)}</b> {c.name}, {c.where}: {formatNumber(c.value)} {c.unit} ({marginText(c.margin)})</li>)}</ul>}
      </Card>
      {of && <Shape key={job?.id} of={of} />}
      {of && <section class="card"><ReportBlocks of={of.blocks} /></section>}
    </>
  );
}

/** The section of a file that has none, and a button that puts it there: undo takes it away. */
const ExampleBracket = ({ known, text }: { known: AppState; text: string }) => (
  <>
    <pre tabindex={0}>{known.bracket_example.trim()}</pre>
    <button data-do="example" onClick={() => store.type(`${text.trimEnd()}\n${known.bracket_example}`, false)}>{t("put this example into the file")}</button>
  </>
);

const bytes = (packed: string): ArrayBuffer => Uint8Array.from(atob(packed), (c) => c.charCodeAt(0)).buffer;

/** Metres of the bracket's frame as three has them, in mm. */
function turned(packed: string): Float32Array {
  const p = new Float32Array(bytes(packed));
  for (let k = 0; k < p.length; k += 3) {
    const [x, y, z] = [p[k] ?? 0, p[k + 1] ?? 0, p[k + 2] ?? 0];
    p.set([1000 * x, 1000 * z, -1000 * y], k);
  }
  return p;
}

/** Blue by green to red, as the report's pictures have it. */
const tone = (share: number): number[] => [4 * share - 1.5, 1.5 - Math.abs(4 * share - 2), 2.5 - 4 * share].map((v) => Math.min(1, Math.max(0.05, v)));

const mm = (p: Point): Point => p.map((v) => 1000 * v) as Point;

function Shape({ of }: { of: Seated }) {
  const [v, setV] = useState(0);
  const [c, setC] = useState(0);
  const [plenty, give] = useState(0.3);
  const [marked, mark] = useState<number | null>(null);
  const variant = of.variants[v] as Variant;
  const shown = variant.cases[Math.min(c, variant.cases.length - 1)] as Case;
  const ends = (): Point[] => {
    const p = turned(variant.points);
    return Array.from({ length: p.length / 3 }, (_, k) => [p[3 * k] ?? 0, -(p[3 * k + 2] ?? 0), p[3 * k + 1] ?? 0]);
  };
  const { box, stage, missing } = useScene3d(t("The bracket in three dimensions"), (s) => { build(s, variant, shown, of, plenty, marked); s.look(ends(), [-0.8, -1, 0.6]); }, [v]);
  useEffect(() => { if (stage.current) build(stage.current, variant, shown, of, plenty, marked); }, [v, shown, plenty, marked]);
  return (
    <Card id="stress" kind="" title={t("Stress where it peaks")} note={t("von Mises, each case when it stresses most")}>
      {of.variants.length > 1 && <div class="chips" role="group" aria-label={t("shape")}>{of.variants.map((o, k) => <button key={o.name} aria-pressed={k === v} onClick={() => setV(k)}>{o.name}</button>)}</div>}
      <div class="chips" role="group" aria-label={t("case")}>{variant.cases.map((o, k) => <button key={o.name} aria-pressed={o === shown} onClick={() => setC(k)}>{o.name}</button>)}</div>
      {missing ? <p class="note">{t("This browser has no 3-D graphics.")}</p> : <div class="canvas marks" ref={box} />}
      <p class="ends colours"><span>0</span><i aria-hidden="true" /><span data-top>{formatFixed(shown.top, 1)} MPa</span></p>
      <label class="slider">{t("deformation")}<output>{plenty === 0 ? t("none") : ""}</output><input type="range" min={0} max={1} step={0.01} value={plenty} onInput={(e) => give(Number(e.currentTarget.value))} /></label>
      <ol class="zones">
        {variant.zones.map((z, k) => (
          <li key={z.said}><button class="link" aria-pressed={marked === k} onClick={() => mark(marked === k ? null : k)}>{z.mark} {z.said}</button>: {formatNumber(z.MPa)} MPa, {z.case} <span class="note">{z.at.map((x) => formatFixed(x, 0)).join(" ")} mm{z.used !== null && `, ${t("{share} % of its fatigue limit", { share: formatNumber(100 * z.used) })}`}</span></li>
        ))}
      </ol>
    </Card>
  );
}

function build(s: Scene3d, v: Variant, c: Case, of: Seated, plenty: number, marked: number | null): void {
  s.clear();
  const [points, u, stress] = [turned(v.points), turned(c.u), new Float32Array(bytes(c.s))];
  const most = (a: Float32Array): number => a.reduce((m, x) => Math.max(m, Math.abs(x)), 0);
  const [size, swing] = [most(points), most(u)];
  const by = (plenty * 0.1 * size) / (swing || 1);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(points.map((x, k) => x + by * (u[k] ?? 0)), 3));
  geometry.setAttribute("color", new THREE.BufferAttribute(Float32Array.from(Array.from(stress, (x) => tone(Math.min(1, x / (c.top || 1)))).flat()), 3));
  geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(bytes(v.faces)), 1));
  geometry.computeVertexNormals();
  s.group.add(new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ vertexColors: true, side: THREE.DoubleSide })));
  const names = new Map<string, Point>([...of.gauges.map((g): [string, Point] => [g.name, mm(g.at)]), ...v.zones.flatMap((z, k): [string, Point][] => (z.mark || k === marked ? [[z.mark || z.said, z.at]] : []))]);
  const chosen = marked === null ? null : v.zones[marked];
  for (const [name, at] of names) {
    const ball = new THREE.Mesh(new THREE.SphereGeometry(size / (at === chosen?.at ? 35 : 70), 16, 12), surfaceMaterial(at === chosen?.at ? "--fail" : "--ink"));
    ball.position.copy(toSceneAxes(at));
    ball.name = name;
    [ball.material.depthTest, ball.renderOrder] = [false, 1];
    s.group.add(ball);
  }
  s.drawn = named;
  s.draw();
}

/** Write the names of the marks over the picture. */
function named(s: Scene3d): void {
  s.box.querySelectorAll("span").forEach((e) => e.remove());
  for (const one of s.group.children.filter((o) => o.name)) {
    const at = one.position.clone().project(s.camera);
    const label = document.createElement("span");
    label.textContent = one.name;
    label.style.left = `${50 + 50 * at.x}%`;
    label.style.top = `${50 - 50 * at.y}%`;
    s.box.append(label);
  }
}
