// The client of ModelService: fetched with the views that ask it, not with the page.
import { lazily } from './client';
import { ModelService } from './gen/driftwise/v1/model_service_pb';

export const modelApi = lazily(ModelService);
