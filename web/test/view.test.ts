import { describe, expect, it } from "vitest";
import type { Laid, Line, Obstacle } from "../src/types";
import { dragVector, pixelsToMillimetres, drawingScale } from "../src/projection";

const laid = (z: number): Laid => ({
  joints: [[0, 0, 0], [1000, 0, -35], [2000, 10, z]],
  bearings: [[850, 0, -30]],
  ends: [[-140, 0, 10], [2140, 10, z]],
  pins: [],
});
const line = { installed: laid(-100), states: [laid(-200), laid(-50)], tubes: [120, 120] } as unknown as Line;
const beam: Obstacle = { name: "b", line: "main", radius: 65, share: 1, start: [1500, -500, -277], end: [1500, 500, -277] };

describe("a page", () => {
  it.each([["side", 900], ["top", 900], ["side", 360]] as const)("has room for the %s view at %s px", (view, width) => {
    const p = drawingScale(line, [beam], view, width, 330);
    const c = view === "side" ? 2 : 1;
    for (const l of [line.installed, ...line.states]) {
      for (const at of [...l.joints, ...l.ends]) {
        expect(p.x(at[0])).toBeGreaterThanOrEqual(0);
        expect(p.x(at[0])).toBeLessThanOrEqual(width);
        expect(p.y(at[c])).toBeGreaterThan(0);
        expect(p.y(at[c])).toBeLessThan(p.height);
      }
    }
  });

  it("goes up where the vehicle goes up, and rearward to the right", () => {
    const p = drawingScale(line, [], "side", 900, 330);
    expect(p.y(10)).toBeLessThan(p.y(0));
    expect(p.x(10)).toBeGreaterThan(p.x(0));
  });

  it("takes a hand's pixels back to the millimetres that moved them", () => {
    const p = drawingScale(line, [], "side", 900, 330);
    const [right, up] = pixelsToMillimetres(p, p.x(37) - p.x(0), p.y(12.3) - p.y(0));
    expect(right).toBeCloseTo(37, 1);
    expect(up).toBeCloseTo(12.3, 1);
  });
});

describe("a handle", () => {
  it("moves along the axes it has, in its view", () => {
    expect(dragVector("yz", "side", 5, 7)).toEqual([0, 0, 7]);
    expect(dragVector("yz", "top", 5, 7)).toEqual([0, 7, 0]);
    expect(dragVector("xyz", "side", 5, 7)).toEqual([5, 0, 7]);
    expect(dragVector("y", "side", 5, 7)).toEqual([0, 0, 0]);
  });
});
