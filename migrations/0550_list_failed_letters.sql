-- Letters that could not be sent, as the service's page lists them: few among many that were.
CREATE INDEX mails_failed ON mails (school_id, id) WHERE error IS NOT NULL AND sent_at IS NULL;
CREATE INDEX survey_letters_failed ON survey_letters (school_id, id) WHERE error IS NOT NULL AND sent_at IS NULL;
