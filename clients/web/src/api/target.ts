// The client of TargetService: fetched with the views that ask it, not with the page.
import { lazily } from './client';
import { TargetService } from './gen/driftwise/v1/target_service_pb';

export const targetApi = lazily(TargetService);
