// Who sits here. The name is typed once, kept by this browser and sent with every call; it is not verified until roles exist.
import { signal } from '@preact/signals';
import { remembered } from './storage';

export const operatorName = signal(remembered.get('operator') ?? '');

export function setOperatorName(name: string): void {
  operatorName.value = name.trim().slice(0, 64);
  remembered.set('operator', operatorName.value);
}
