// What only the JSON of a comparison says (driftwise.comparison.v1): intervals, all outputs together, the geometry identified.
export interface MethodJson {
  method: string;
  outputs: Record<string, Record<string, number | string | readonly number[] | null>>;
  position?: Record<string, number | null>;
  kinematics?: { kind: string; parameters: readonly GeometryParameter[] };
}

export interface GeometryParameter {
  name: string; // "a2_mm"
  nominal: number;
  value: number | null;
  free: boolean; // estimated; else held at its nominal value, and note says why
  standard_error?: number | null;
  note?: string;
}

// Empty where the daemon's text is not what it was: the table stands without what it would have added.
export function methodsOf(json: string): readonly MethodJson[] {
  try {
    const answer = JSON.parse(json) as { methods?: readonly MethodJson[] };
    return Array.isArray(answer.methods) ? answer.methods : [];
  } catch {
    return [];
  }
}

// 90 % interval of a held-out figure: "a90_blocks" of "q1", in its summary unit.
export function intervalOf(method: MethodJson | undefined, symbol: string, figure: string, unit: string): readonly [number, number] | undefined {
  const found = method?.outputs[symbol]?.[`${figure}_ci90_${unit}`];
  return Array.isArray(found) && found.length === 2 && found.every(Number.isFinite) ? [found[0], found[1]] : undefined;
}
