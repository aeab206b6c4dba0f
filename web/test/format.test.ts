import { afterEach, describe, expect, it } from "vitest";
import { formatFixed, formatNumber, formatPercent, formatSigned, marginText, setNumberLanguage } from "../src/format";
import { wrapDegrees } from "../src/YokePhaseDials";
import { axisDecimals } from "../src/Plot";

afterEach(() => setNumberLanguage("en"));

describe("numbers", () => {
  // As `cardan.render.i18n.Language.number` has them.
  it.each([
    [11.163, "11.16"], [3004.4, "3004"], [0.51789, "0.5179"], [16233.2, "16233"], [-2.5, "−2.500"],
    [0, "0"], [1e-9, "0"], [null, "–"], [undefined, "–"], [NaN, "–"], [12345678, "1.235e+7"],
  ])("%s is %s", (value, said) => expect(formatNumber(value)).toBe(said));

  it("has the decimal sign of the language", () => {
    setNumberLanguage("pt");
    expect(formatNumber(11.163)).toBe("11,16");
    expect(formatFixed(-0.04, 1)).toBe("0,0");
    expect(formatSigned(1.25, 1)).toMatch(/^\+1,[23]$/);
  });

  it.each([
    [-0.256, "−26"], [0.5, "+50"], [-0.003, "−0.3"], [0, "0"], [-12, "< −999"], [40, "> 999"], [null, ""],
  ])("a margin of %s is %s %%", (margin, said) => expect(formatPercent(margin)).toBe(said));
});

describe("a yoke phase", () => {
  it.each([[0, 0], [190, -170], [-190, 170], [180, 180], [-180, 180], [360, 0], [44.96, 45], [720.04, 0]])(
    "%s is %s",
    (turned, is) => expect(wrapDegrees(turned)).toBe(is),
  );
});

describe("ticks", () => {
  it("have the decimals that their steps have: 12.5 is not 13", () => {
    expect(axisDecimals([0, 2.5, 5])).toBe(1);
    expect([[0, 5], [0, 0.5], [0, 0.25], [0, 0.001], [3]].map(axisDecimals)).toEqual([0, 1, 2, 3, 0]);
  });
});

describe("a margin in words", () => {
  it.each([
    [-3.54, "far beyond"], [-1, "−100 %"], [-0.744, "−74 %"], [0, "0 %"], [1, "+100 %"], [1.01, "ample"], [12, "ample"], [null, ""], [Number.NaN, ""],
  ])("%s is %s", (margin, said) => expect(marginText(margin)).toBe(said));
});
