import { describe, expect, it } from 'vitest';
import { completionAt, take, type Known } from '@/formula/complete';

const known: Known = {
  channels: [
    { symbol: 'q1', unit: 'mm' }, { symbol: 'x', unit: 'mm' }, { symbol: 'y', unit: 'mm' },
    { symbol: 't06', unit: 'degC' }, { symbol: 't07', unit: 'degC' }, { symbol: 'force', unit: 'N' },
  ],
  effects: [{ name: 'lag', usage: 'lag(t, tau s)', sentence: 'the channel behind a first-order lag' }],
};
const labels = (text: string, caret = text.length) => completionAt(text, caret, known).offers.map((offer) => offer.label);

describe('completion of a formula', () => {
  it('offers motor coordinates on the left', () => {
    expect(labels('')).toEqual(['q', 'q1']);
    expect(labels('q')).toEqual(['q1']);
  });
  it('offers short forms, channels and effects after an operator, but no output', () => {
    const offered = labels('q ~ ');
    expect(offered).toContain('poly(x, y, 3)');
    expect(offered).toContain('t06..t07');
    expect(offered).toContain('lag(t, tau s)');
    expect(offered).not.toContain('q1');
  });
  it('narrows by what is typed', () => {
    expect(labels('q ~ x + t')).toEqual(['T', 't06..t07', 't06', 't07']);
  });
  it('keeps quiet where an operator has to follow', () => {
    expect(labels('q ~ x ')).toEqual([]);
  });
  it('offers channels alone within an effect', () => {
    expect(labels('q ~ lag(')).toEqual(['q1', 'x', 'y', 't06', 't07', 'force']);
  });
  it('replaces the word under the caret, in the middle of a text too', () => {
    const text = 'q ~ x + la + T';
    const completion = completionAt(text, 10, known);
    expect(take(text, completion, completion.offers[0])).toEqual({ text: 'q ~ x + lag() + T', caret: 12 });
  });
});
