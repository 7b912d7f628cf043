-- An email address belongs to one account of a school, no longer to one of the service: an administrator who adds an address must not
-- learn whether another school has it.
ALTER TABLE people ADD CONSTRAINT people_school_id_email_key UNIQUE (school_id, email);
ALTER TABLE people DROP CONSTRAINT people_email_key;
CREATE INDEX people_by_email ON people (email);
