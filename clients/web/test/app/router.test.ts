// Addresses as they come, also cut ones.
import { expect, test } from 'vitest';
import { go, segments } from '@/app/router';

test('an address with a stray percent sign names its view all the same', () => {
  go('/runs/50%');
  expect(segments.value).toEqual(['runs', '50%']);
  go('/runs/a%20b');
  expect(segments.value).toEqual(['runs', 'a b']);
});
