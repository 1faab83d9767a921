// Causes of the catalogue as people say them; the ids are the daemon's and stand beside them where a program may want them.
const words: Record<string, readonly [noun: string, link: string]> = {
  geometry_order: ['missing terms of the geometry', 'in'],
  geometry_parameter: ['a length or angle other than drawn', 'of'],
  thermal_offset: ['an offset', 'with'],
  thermal_lag: ['a delay', 'behind'],
  thermal_rate: ['the speed of change', 'of'],
  thermal_expansion: ['expansion', 'with'],
  self_heating: ['heat from the motion', 'of'],
  activity_heating: ['heat that goes', 'with'],
  force_compliance: ['giving way in proportion', 'to'],
  force_nonlinearity: ['giving way out of proportion', 'to'],
  force_position_coupling: ['stiffness that depends on the place', 'under'],
  backlash: ['play', 'of'],
  creep: ['creep after moves', 'of'],
  cyclic_error: ['a periodic error', 'along'],
  abbe_offset: ['a lever arm times tilt', 'of'],
  cosine_error: ['a misaligned beam', 'of'],
  refractive_index: ['the air on the beam', 'of'],
  instrument_drift: ['a steady drift', 'of'],
  step_change: ['a jump', 'of'],
  periodic_disturbance: ['something periodic in time', 'in'],
  joint_compliance: ['sag under gravity', 'of'],
  gear_error: ['uneven turning', 'of'],
  joint_offset_drift: ['a moving zero', 'of'],
  sensor_fault: ['a faulty sensor,', ''],
  outliers: ['isolated wrong rows', 'of'],
  noise_change: ['a changed spread', 'of'],
  probe_hysteresis: ['two sides', 'of'],
};

// "thermal_expansion t03" -> "expansion with t03"; an id that is not known stays as it is.
export function causeText(cause: string, subject = ''): string {
  const [id, ...rest] = cause.split(' ');
  const of = [...rest, subject].filter((part) => part !== '').join(' ');
  const known = words[id];
  if (!known) return [id, of].filter((part) => part !== '').join(' ');
  return of === '' ? known[0].replace(/,$/, '') : [known[0], known[1], of].filter((part) => part !== '').join(' ');
}

// The daemon's ids within a sentence: "thermal_expansion t04 was named first" -> "expansion with t04 was named first". Only where a
// subject follows: "creep" and "backlash" are words of their own.
const within = new RegExp(`\\b(${Object.keys(words).join('|')}) ((?:[a-z]+\\d+|r?[xyz]|F|force)(?:[:^][\\w]+)*)(?![\\w])`, 'g');
export const withCauses = (sentence: string): string => sentence.replace(within, (_, id: string, of: string) => causeText(id, of));
