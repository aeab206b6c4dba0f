// Yoke phases: a dial a shaft, the sum over its phase, and the speed round the turn.

import { useState } from "preact/hooks";
import { Card } from "./Card";
import { formatFixed } from "./format";
import { Plot } from "./Plot";
import { store, type AppState } from "./store";
import { t } from "./i18n";
import type { ShownLine } from "./Drawing";
import { useDragHandlers } from "./hooks";

const R = 46;

export function YokePhaseDials({ known, shown }: { known: AppState; shown: ShownLine }) {
  const { line } = shown;
  const turn = known.pose?.turn;
  const [chosen, choose] = useState(0);
  const shaft = Math.min(chosen, line.phases.length - 1);
  const phase = line.phases[shaft] ?? 0;
  const over = t("equivalent angle over the phase of shaft {n}", { n: shaft + 1 });
  const round = t("speed over the gearbox's, less 1 [%], round the turn [deg]");
  return (
    <Card id="dials" title={t("Yoke phases")} note={t("seen from the gearbox")}>
      <div class="row">{line.phases.map((p, k) => (<Dial key={k} phase={p} address={line.phase_at[k] ?? ""} shaft={k} chosen={k === shaft} held={known.held} choose={() => choose(k)} />))}</div>
      {turn && (
        <div class="curves">
          <Plot
            x={turn.phases} series={[{ name: over, values: turn.over_phase[shaft] ?? [], colour: 0 }]} degrees
            unit={t("[deg] over deg")} at={((phase % 180) + 180) % 180} height={130} theme={known.theme} label={over}
          />
          <Plot
            x={turn.theta} series={turn.speed.map((values, k) => ({ name: k === turn.speed.length - 1 ? t("pinion") : t("shaft {n}", { n: k + 1 }), values, colour: k % 6 }))}
            unit={round} height={150} theme={known.theme} label={round}
          />
        </div>
      )}
    </Card>
  );
}

function Dial(of: { phase: number; address: string; shaft: number; chosen: boolean; held: string | null; choose: () => void }) {
  const { phase, address, shaft } = of;
  const name = `phase/${address}`;
  const [from, start] = useState<number | null>(null);
  const base = of.held === name ? (from ?? phase) : phase;
  const to = (degrees: number): void => {
    if (of.held !== name) start(phase);
    store.hold(name, { edits: { [address]: wrapDegrees(degrees) } }, ["turn"]);
  };
  const hand = useDragHandlers({
    // Along the page: a degree each half pixel's way round, in steps a fitter can set.
    moved: (dx, dy) => to(Math.round(base + (dx - dy) * 0.7)),
    stepped: (right, up) => to(base + right + up),
    release: () => store.release(),
    cancel: () => store.cancel(),
  });
  const [sin, cos] = [Math.sin((phase * Math.PI) / 180), Math.cos((phase * Math.PI) / 180)];
  const label = t("phase of shaft {n}: drag, or use the arrow keys", { n: shaft + 1 });
  return (
    <div class={`dial ${of.chosen ? "chosen" : ""}`}>
      <svg
        viewBox="-64 -64 128 128" tabindex={0} role="slider" aria-label={label}
        aria-valuemin={-180} aria-valuemax={180} aria-valuenow={phase}
        aria-valuetext={`${formatFixed(phase, 1)}°`}
        data-handle={name}
        onFocus={of.choose}
        {...hand}
      >
        <title>{label}</title>
        <circle class="rim" r={R} />
        {Array.from({ length: 24 }, (_, k) => (<path key={k} class="tick" d={`M0 ${-R}V${-R + (k % 6 ? 4 : 8)}`} transform={`rotate(${k * 15})`} />))}
        <line class="front" x1={0} y1={-R - 8} x2={0} y2={R + 8} />
        <line class="rear" x1={-(R + 8) * sin} y1={(R + 8) * cos} x2={(R + 8) * sin} y2={-(R + 8) * cos} />
        <circle class="knob" cx={(R + 8) * sin} cy={-(R + 8) * cos} r={7} />
      </svg>
      <p>{t("shaft {n}", { n: shaft + 1 })} <b>{formatFixed(phase, 1)}°</b></p>
      <p class="set">
        {[0, 90].map((v) => (
          <button key={v} class="plain" aria-pressed={Math.abs(phase - v) < 1e-6} onClick={() => { of.choose(); store.apply({ [address]: v }); }}>
            {v}°
          </button>
        ))}
      </p>
    </div>
  );
}

/** Between −180 and 180, in tenths. */
export function wrapDegrees(degrees: number): number {
  const round = Math.round(degrees * 10) / 10;
  const within = ((((round + 180) % 360) + 360) % 360) - 180;
  return within === -180 ? 180 : within + 0;
}
