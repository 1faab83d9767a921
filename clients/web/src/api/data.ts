// The client of DataService: fetched with the views that ask it, not with the page.
import { lazily } from './client';
import { DataService } from './gen/driftwise/v1/data_service_pb';

export const dataApi = lazily(DataService);
