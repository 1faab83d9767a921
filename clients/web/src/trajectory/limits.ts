import { api } from '@/api/client';
import { useAsked } from '@/ui/use_asked';

export interface SoftLimit {
  channel: string; // "q1_mm"
  min: number; // mm
  max: number;
}

export interface CellLimits {
  axes: SoftLimit[];
  actuator: boolean; // a device changes the force; without one a person does
}

export function useLimits() {
  return useAsked<CellLimits>('soft limits', async (signal) => {
    const { devices } = await api.cell().listDevices({}, { signal });
    return {
      axes: devices.flatMap((device) => device.axes.map((axis) => ({ channel: axis.channel, min: axis.minMm, max: axis.maxMm }))),
      actuator: devices.some((device) => device.forceChannel !== ''),
    };
  });
}
