// What could stand where the caret is: channels of the data, short forms, poly and effects. It only proposes; what is
// right is the daemon's to say (ModelService.CheckFormula).

import { unitSign } from '@/format/units';

export interface Offer {
  insert: string; // takes the place of the word under the caret
  back: number; // characters the caret steps back after it: into the parentheses
  label: string; // "lag(t, tau s)"
  detail: string; // "channel, °C"; "the channel behind a first-order lag"
}

export interface Completion {
  from: number; // the word under the caret
  to: number;
  offers: Offer[];
  exact: boolean; // the word is a name already: longer names are offered only to a person who asks for them
}

export interface Known {
  channels: readonly { symbol: string; unit: string }[];
  effects: readonly { name: string; usage: string; sentence: string }[];
}

const word = /[A-Za-z0-9_]/;
const isMotor = (symbol: string) => /^q\d+$/.test(symbol);

export function completionAt(text: string, caret: number, known: Known): Completion {
  let from = caret;
  while (from > 0 && word.test(text[from - 1])) --from;
  let to = caret;
  while (to < text.length && word.test(text[to])) ++to;
  const typed = text.slice(from, caret).toLowerCase();
  const tilde = text.indexOf('~');
  const left = tilde < 0 || caret <= tilde;
  const afterOperator = /[~+:*(,-]\s*$/.test(text.slice(0, from));
  const all = left ? outputs(known) : terms(known, insideEffect(text.slice(0, from)));
  const offers = all.filter((offer) => offer.insert.toLowerCase().startsWith(typed) && offer.insert !== text.slice(from, to));
  // Exact names are case-sensitive, as in the formula itself: t is not T.
  const exact = all.some((offer) => offer.insert === text.slice(from, to));
  // Nothing typed yet: propose only where something has to follow.
  return { from, to, exact, offers: typed === '' && !left && !afterOperator ? [] : typed === '' && left && from > 0 ? [] : offers };
}

// Within the parentheses of an effect or of poly only channels make sense.
function insideEffect(before: string): boolean {
  let depth = 0;
  for (let i = before.length - 1; i >= 0; --i) {
    if (before[i] === ')') ++depth;
    else if (before[i] === '(' && depth-- === 0) return word.test(before[i - 1] ?? '');
  }
  return false;
}

const plain = (insert: string, detail: string): Offer => ({ insert, back: 0, label: insert, detail });

function outputs(known: Known): Offer[] {
  const motors = known.channels.filter((channel) => isMotor(channel.symbol));
  return [
    plain('q', `every motor coordinate${motors.length ? `: ${motors.map((m) => m.symbol).join(', ')}` : ''}`),
    ...motors.map((channel) => plain(channel.symbol, 'motor coordinate')),
  ];
}

function terms(known: Known, channelsOnly: boolean): Offer[] {
  const channels = known.channels.map((channel) => plain(channel.symbol, unitSign(channel.unit)));
  if (channelsOnly) return channels;
  const pose = ['x', 'y', 'z', 'rx', 'ry', 'rz'].filter((symbol) => known.channels.some((c) => c.symbol === symbol));
  const lengths = pose.filter((symbol) => symbol.length === 1);
  const structure = known.channels.filter((channel) => /^t\d\d$/.test(channel.symbol)).map((c) => c.symbol);
  const short: Offer[] = [];
  if (lengths.length)
    short.push({ insert: `poly(${lengths.join(', ')}, 3)`, back: 0, label: `poly(${lengths.join(', ')}, 3)`, detail: 'every product of powers up to degree 3' });
  if (structure.length) {
    short.push(plain('T', `every structure temperature: ${structure[0]} to ${structure[structure.length - 1]}`));
    short.push(plain('R', 'the thermometers on the robot, as the cell file declares them: for a model that serves'));
    if (structure.length > 1) short.push(plain(`${structure[0]}..${structure[structure.length - 1]}`, 'a range of temperatures'));
  }
  if (known.channels.some((channel) => channel.symbol === 'force')) short.push(plain('F', 'the force, N'));
  const effects = known.effects.map((effect) => ({ insert: `${effect.name}()`, back: 1, label: effect.usage, detail: effect.sentence }));
  return [...short, ...channels.filter((offer) => !isMotor(offer.insert)), ...effects];
}

// The text with an offer taken, and where the caret then stands.
export function take(text: string, completion: Completion, offer: Offer): { text: string; caret: number } {
  const caret = completion.from + offer.insert.length - offer.back;
  return { text: text.slice(0, completion.from) + offer.insert + text.slice(completion.to), caret };
}
