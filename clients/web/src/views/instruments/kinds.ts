// Words for instruments by the kind of their device; a kind without a word here has a general one.
const lengths: Readonly<Record<string, string>> = { 'interferometer-adapter': 'interferometer', 'heidenhain-nd28x': 'touch probe' };
const angles: Readonly<Record<string, string>> = { 'newport-lds1000': 'Autocollimator', 'meas-dpl': 'Inclinometer' };

export const lengthInstrument = (kind: string): string => lengths[kind] ?? 'length';
export const angleInstrument = (kind: string): string => angles[kind] ?? 'Angles of';
