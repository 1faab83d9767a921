// The client of ConfigurationService: fetched with the views that ask it, not with the page.
import { lazily } from './client';
import { ConfigurationService } from './gen/driftwise/v1/configuration_service_pb';

export const configurationApi = lazily(ConfigurationService);
