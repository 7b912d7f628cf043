-- Tokens of people have a name and an end. Those of before have neither, and go on until they are revoked.
ALTER TABLE api_tokens ADD COLUMN name TEXT; -- what its owner calls it
ALTER TABLE api_tokens ADD COLUMN expires_at INTEGER; -- absent: never
CREATE INDEX api_tokens_by_person ON api_tokens (person_id) WHERE person_id IS NOT NULL;
