// A joint pose as a person types it, and the answer's parts as words.
import { RobotAnswer_By, type RobotAnswer } from '@/api/gen/driftwise/v1/plan_service_pb';
import { fixed } from '@/format/numbers';
import { numberTyped } from '@/ui/field';

const unitOf = (symbol: string): string | undefined =>
  ({ x: 'mm', y: 'mm', z: 'mm', rx: 'arcsec', ry: 'arcsec', rz: 'arcsec', force: 'N' })[symbol.slice(symbol.indexOf('.') + 1)];

// "mn.x=1 ma.rx=100": undefined where something is no coordinate with a number.
export function jointPoseTyped(text: string): { channel: string; value: number }[] | undefined {
  const words = text.trim().split(/[\s;]+/).filter(Boolean);
  const pose = words.map((word) => {
    const [name, number] = word.split('=');
    const symbol = name.replace(/_(mm|arcsec|N)$/, '');
    const unit = unitOf(symbol);
    const value = numberTyped(number ?? '');
    return unit === undefined || value === undefined ? undefined : { channel: `${symbol}_${unit}`, value };
  });
  return pose.length > 0 && pose.every((one) => one !== undefined) ? pose : undefined;
}

export function answeredBy(robot: RobotAnswer): string {
  const fine = `model ${robot.modelId}`;
  const coarse = `model ${robot.coarseModelId}`;
  switch (robot.by) {
    case RobotAnswer_By.FINE:
      return `${fine}, the fine one`;
    case RobotAnswer_By.COARSE:
      return `${coarse}, the coarse one`;
    case RobotAnswer_By.BLEND:
      return `${fixed(robot.fineWeight, 3)} of ${fine}, the rest of ${coarse}; they differ by ${fixed(robot.differenceNm, 1)} nm`;
    default:
      return fine;
  }
}
