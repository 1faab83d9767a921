// Flags of targets, which programs read by name, in words for people. A joint target has them as text: "OUTSIDE_DOMAIN(t19_degC)".
import { splitChannel } from '@/format/units';

const words: Record<string, string> = {
  OUTSIDE_DOMAIN: 'outside what the model was fitted on',
  STALE_TEMPERATURE: 'a temperature is too old',
  MISSING_TEMPERATURE: 'a temperature was never read: the middle of its range stands in',
  EXPIRED_CONDITIONS: 'the conditions were not looked at in time',
  OUTSIDE_LIMITS: 'not reachable: beyond the soft limits',
  UNKNOWN_LIMITS: 'no soft limits are known: whether it can be reached is not checked',
  IGNORED_COORDINATE: 'the model does not depend on a stated coordinate',
  CONFIGURATION_CHANGED: 'the cell file has changed, in parts that this model does not use; nobody has accepted it yet',
  UNJUDGED_MODEL: 'no data judged the model',
  DOUBTFUL_MODEL: 'the robot no longer does what the model says: recalibrate; the error may exceed the uncertainty',
  UNANCHORED_DATUM: 'the present datum is not known: the constant is that of the model\'s own',
  ZERO_OUTSIDE_DOMAIN: 'the zero of the present datum was taken outside what the model was fitted on',
  BLENDED: 'by a blend of both models of a robot',
  COARSE: 'by the coarse model of a robot',
};

// about: channels, or the id of a robot; each is named once.
export function flagInWords(name: string, about: readonly string[] = []): string {
  const named = [...new Set(about.map((one) => splitChannel(one).symbol))].join(', ');
  return `${words[name] ?? name}${named && ` (${named})`}`;
}

// Flags of a text, each name once with all that it is about, in the order of the text. What is no flag stays as it is.
export function flagsInWords(texts: readonly string[]): string[] {
  const about = new Map<string, string[]>();
  for (const text of texts) {
    const flags = [...text.matchAll(/\b([A-Z][A-Z_]{3,})(?:\(([^)]*)\))?/g)];
    if (flags.length === 0) about.set(text, []);
    for (const [, name, whom] of flags) about.set(name, [...(about.get(name) ?? []), ...(whom ? whom.split(/[ +,]+/) : [])]);
  }
  return [...about].map(([name, whom]) => flagInWords(name, whom));
}
