"""The mission language as it is written: its keys, and files read into specs with places."""
