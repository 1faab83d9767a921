// The client of LookBackService: fetched with what asks it, not with the page.
import { lazily } from './client';
import { LookBackService } from './gen/driftwise/v1/look_back_service_pb';

export const lookBackApi = lazily(LookBackService);
