-- How long the data of a study are kept is promised to whoever takes part: when their end was announced, and when they went.
ALTER TABLE studies ADD COLUMN told_at INTEGER; -- by the clock
ALTER TABLE studies ADD COLUMN told_observed_s INTEGER; -- by the time that the service has run
ALTER TABLE studies ADD COLUMN erased_at INTEGER;
CREATE INDEX studies_to_erase ON studies (school_id, closed_at) WHERE closed_at IS NOT NULL AND erased_at IS NULL;
