// A curve or some, by uPlot: its colours from the page, its cursor where the slider stands.

import { useEffect, useLayoutEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { formatFixed } from "./format";
import { cssColour, useElementWidth } from "./hooks";

export interface Series {
  name: string;
  values: (number | null)[];
  /** Number of the colour in the page's palette. */
  colour: number;
  dash?: boolean;
}

/** What is drawn beside the curves: values they are held against, places, a range of x. */
export interface PlotAnnotations {
  levels?: { value: number; said?: string; grade?: string }[];
  spots?: { x: number; y: number }[];
  shade?: [number, number] | null;
  /** The top of the left axis; by default what the curves need. */
  top?: number;
}

interface Drawn { x: number[]; series: Series[]; unit: string; label: string; height: number; theme: string; degrees?: boolean; at?: number | null; beside?: PlotAnnotations;
  /** Ends of the lower axis where it is shared with a map above: nothing is left free beside it. */
  range?: [number, number];
}

export function Plot(of: Drawn) {
  const [box, width] = useElementWidth(420);
  const root = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const here = useRef<HTMLElement | null>(null);
  const at = useRef(of.at);
  at.current = of.at;
  // The cursor stands above the curves: they are not drawn again where it alone moves.
  const place = (u: uPlot): void => {
    const x = at.current;
    if (here.current) here.current.style.transform = x === null || x === undefined ? "scale(0)" : `translateX(${u.valToPos(x, "x")}px)`;
  };
  const shape = JSON.stringify([of.series.map((s) => [s.name, s.colour]), of.unit, of.height, of.theme, of.beside, of.range]);

  useEffect(() => {
    const element = root.current;
    if (!element) return undefined;
    const axis = { stroke: cssColour("--faint"), grid: { stroke: cssColour("--line"), width: 1 }, ticks: { show: false }, font: "11px system-ui", size: 34 };
    const ticks = (unit: string) => (_: uPlot, values: number[]) => values.map((v) => formatFixed(v, axisDecimals(values)) + unit);
    // A number at the very end of an axis with no room next to it would be cut.
    const within = ([low, high]: [number, number]) => (u: uPlot, values: number[]) => ticks("")(u, values).map((said, k) => ((values[k] ?? 0) > high - (20 / u.width) * (high - low) ? "" : said));
    plot.current = new uPlot(
      {
        width,
        height: of.height,
        legend: { show: false },
        cursor: { show: false },
        scales: { x: { time: false, ...(of.range ? { range: of.range } : {}) }, ...(of.beside?.top ? { y: { range: [0, of.beside.top] as [number, number] } } : {}) },
        pxAlign: 0,
        padding: [8, of.range ? 0 : 18, 0, 0],
        axes: [
          { ...axis, size: 22, values: of.range ? within(of.range) : ticks("") },
          { ...axis, size: 44, values: ticks(of.degrees ? "°" : "") },
        ],
        series: [{}, ...of.series.map((s) => ({ stroke: cssColour(`--series-${s.colour}`), width: 1.8, points: { show: false }, ...(s.dash ? { dash: [6, 4] } : {}) }))],
        hooks: {
          draw: [(u) => besides(u, of.beside ?? {}), place],
          init: [(u) => { here.current = u.over.appendChild(document.createElement("i")); here.current.className = "here"; }],
        },
      },
      data(of.x, of.series),
      element,
    );
    return () => {
      plot.current?.destroy();
      plot.current = null;
    };
  }, [shape]);

  useEffect(() => plot.current?.setSize({ width, height: of.height }), [width]);
  useEffect(() => plot.current?.setData(data(of.x, of.series)), [of.x, of.series]);
  useLayoutEffect(() => { if (plot.current) place(plot.current); }, [of.at]);

  return (
    <div class="plot" ref={box} role="img" aria-label={of.label}>
      <div ref={root} />
      <p class="legend" aria-hidden="true">
        {of.series.map((s) => (<span key={s.name} class={`key key-${s.colour} ${s.dash ? "dash" : ""}`}>{s.name}</span>))}
        <span class="unit">{of.unit}</span>
      </p>
    </div>
  );
}

function besides(u: uPlot, { levels = [], spots = [], shade }: PlotAnnotations): void {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  if (shade) {
    const [a, b] = shade.map((x) => u.valToPos(x, "x", true)) as [number, number];
    ctx.fillStyle = cssColour("--accent");
    ctx.globalAlpha = 0.1;
    ctx.fillRect(a, bbox.top, b - a, bbox.height);
    ctx.globalAlpha = 1;
  }
  ctx.font = `${11 * devicePixelRatio}px system-ui`;
  [ctx.textAlign, ctx.textBaseline] = ["left", "bottom"]; // the axes leave another
  const rising = levels.map((l) => ({ ...l, y: u.valToPos(l.value, "y", true), ink: cssColour(l.grade ? `--${l.grade}` : "--faint") })).sort((a, b) => a.value - b.value);
  for (const { y, grade, ink } of rising) {
    ctx.lineWidth = 1.3 * devicePixelRatio;
    ctx.strokeStyle = ink;
    ctx.setLineDash(grade ? [8, 5] : [2, 3]);
    ctx.stroke(new Path2D(`M${bbox.left} ${y}h${bbox.width}`));
  }
  let [x, last] = [0, -99];
  ctx.setLineDash([]);
  for (const { y, said, ink } of rising) {
    if (!said) continue;
    // Names of neighbours stand beside each other.
    x = Math.abs(y - last) < 13 * devicePixelRatio ? x : bbox.left + bbox.width;
    x -= ctx.measureText(said).width + 8;
    last = y;
    // On the line, and before others that cross it.
    [ctx.strokeStyle, ctx.fillStyle, ctx.lineWidth] = [cssColour("--card"), ink, 4 * devicePixelRatio];
    ctx.strokeText(said, x, y - 1);
    ctx.fillText(said, x, y - 1);
  }
  ctx.lineWidth = 1.3 * devicePixelRatio;
  ctx.strokeStyle = cssColour("--ink");
  for (const { x, y } of spots) {
    ctx.beginPath();
    ctx.arc(u.valToPos(x, "x", true), u.valToPos(y, "y", true), 4 * devicePixelRatio, 0, 7);
    ctx.stroke();
  }
  ctx.restore();
}

const data = (x: number[], series: Series[]): uPlot.AlignedData => [x, ...series.map((s) => s.values)] as uPlot.AlignedData;

/** Decimals that ticks have, up to four: 2.5 stands between 2 and 3. */
export function axisDecimals(values: number[]): number {
  const step = Math.abs((values[1] ?? 1) - (values[0] ?? 0)) || 1;
  return [0, 1, 2, 3].find((d) => Math.abs(step * 10 ** d - Math.round(step * 10 ** d)) < 1e-6) ?? 4;
}
