-- In which language a school writes to whoever has chosen none, and what it writes of its own accord.
ALTER TABLE schools ADD COLUMN letter_language TEXT; -- a code as people's; NULL: English
ALTER TABLE schools ADD COLUMN mails_reminders INTEGER NOT NULL DEFAULT 1 CHECK (mails_reminders IN (0, 1)); -- of what is due
ALTER TABLE schools ADD COLUMN mails_news INTEGER NOT NULL DEFAULT 1 CHECK (mails_news IN (0, 1)); -- to whoever wants them
