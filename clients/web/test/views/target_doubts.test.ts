// Every flag of a target is told in words: a number would tell a person nothing.
import { create } from '@bufbuild/protobuf';
import { expect, it } from 'vitest';
import { Target_Flag, TargetSchema } from '@/api/gen/driftwise/v1/target_service_pb';
import { doubtsOf } from '@/views/targets/result';

const flags = Object.values(Target_Flag).filter((flag): flag is Target_Flag => typeof flag === 'number' && flag !== Target_Flag.UNSPECIFIED);

it('has words for every flag that the API knows', () => {
  for (const { words } of doubtsOf(create(TargetSchema, { flags }))) expect(words).not.toMatch(/^flag \d+/);
});

it('names the channels of a zero that was taken outside the fitted range', () => {
  const target = create(TargetSchema, { flags: [Target_Flag.ZERO_OUTSIDE_DOMAIN, Target_Flag.DOUBTFUL_MODEL], zeroOutsideChannels: ['t06_degC', 'force_N'] });
  expect(doubtsOf(target).map(({ words }) => words)).toEqual([
    'the zero of the present datum was taken outside what the model was fitted on (t06, force)',
    'the robot no longer does what the model says: recalibrate; the error may exceed the uncertainty',
  ]);
});
