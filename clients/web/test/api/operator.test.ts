import { expect, it } from 'vitest';
import { operatorHeader } from '@/api/client';

it('sends the name as the command line does: plain ASCII as it is, else base64 of UTF-8 under the -bin key', () => {
  expect(operatorHeader('')).toBeUndefined();
  expect(operatorHeader('Anna')).toEqual(['driftwise-operator', 'Anna']);
  expect(operatorHeader('Zoë')).toEqual(['driftwise-operator-bin', 'Wm/Dqw']);
});
