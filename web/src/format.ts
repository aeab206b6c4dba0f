// Numbers as an engineer writes them, with the language's decimal sign.

import { t } from "./i18n";

let sign = ".";

export function setNumberLanguage(lang: string): void { sign = lang === "en" ? "." : ","; }

export const withDecimalSign = (said: string): string => said.replace(".", sign).replace(/^-/, "−");

/** Four figures. */
export function formatNumber(value: number | null | undefined): string {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (Math.abs(value) < 5e-7) return "0";
  const size = Math.floor(Math.log10(Math.abs(value)));
  return withDecimalSign(size >= -3 && size < 7 ? value.toFixed(Math.max(0, 3 - size)) : value.toExponential(3));
}

export function formatFixed(value: number | null | undefined, digits: number): string {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  return withDecimalSign((Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value).toFixed(digits));
}

export const formatSigned = (value: number, digits: number): string =>
  (value > 0 && Number(value.toFixed(digits)) !== 0 ? "+" : "") + formatFixed(value, digits);

/** A margin in per cent, short enough for a cell. */
export function formatPercent(margin: number | null | undefined): string {
  if (margin === null || margin === undefined || Number.isNaN(margin)) return "";
  if (margin < -9.99) return "< −999";
  if (margin > 9.99) return "> 999";
  return formatSigned(100 * margin, margin !== 0 && Math.abs(margin) < 0.0095 ? 1 : 0);
}

/** A margin in per cent with its sign; beyond 100 % in words, where a number says no more. */
export function marginText(margin: number | null | undefined): string {
  if (margin === null || margin === undefined || Number.isNaN(margin)) return "";
  if (margin < -1) return t("far beyond");
  return margin > 1 ? t("ample") : `${formatPercent(margin)} %`;
}

/** A name with the marks written out that turn the writing of names round, and are not seen. */
export const showHiddenMarks = (name: string): string =>
  name.replace(/[\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]/g, (mark) => `\\u${mark.charCodeAt(0).toString(16).padStart(4, "0")}`);
