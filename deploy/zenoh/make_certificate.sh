#!/bin/sh
# Issue a certificate by an authority of the lab's own, which is made at the first call:
#
#   deploy/zenoh/make_certificate.sh FOLDER NAME [HOST ...]
#
# NAME is the common name, as in lab.toml. HOST are the names and addresses under which a server with this certificate
# is reached (the router, the balancer, `voa serve --tls-cert`): "lab.example", "192.168.0.2". Leaves FOLDER/NAME.pem
# and FOLDER/NAME.key, valid for DAYS (825), and FOLDER/ca.pem. Keep FOLDER/ca.key offline: who has it can be anyone.
set -eu
[ $# -ge 2 ] || { echo "usage: $0 FOLDER NAME [HOST ...]" >&2; exit 2; }
folder=$1; name=$2; shift 2
case $name in *[!A-Za-z0-9_.-]*|"") echo "$0: expected letters, digits, '_', '.' and '-', got '$name'" >&2; exit 2;; esac
umask 077
mkdir -p "$folder"
cd "$folder"
if [ ! -e ca.key ]; then
  openssl ecparam -name prime256v1 -genkey -noout -out ca.key
  openssl req -x509 -new -key ca.key -days "${CA_DAYS:-3650}" -subj "/CN=VOA lab" -out ca.pem \
    -addext "keyUsage=critical,keyCertSign,cRLSign"
fi
hosts=""
for host in "$@"; do
  case $host in *:*|*[!0-9.]*) kind=DNS;; *) kind=IP;; esac
  case $host in *:*) kind=IP;; esac
  hosts="$hosts,$kind:$host"
done
{
  echo "basicConstraints=critical,CA:FALSE"
  echo "keyUsage=critical,digitalSignature"
  echo "extendedKeyUsage=clientAuth,serverAuth"
  echo "subjectAltName=DNS:$name$hosts"
} > "$name.ext"
openssl ecparam -name prime256v1 -genkey -noout | openssl pkcs8 -topk8 -nocrypt -out "$name.key"
openssl req -new -key "$name.key" -subj "/CN=$name" |
  openssl x509 -req -CA ca.pem -CAkey ca.key -CAcreateserial -days "${DAYS:-825}" -extfile "$name.ext" \
    -out "$name.pem" 2>/dev/null
rm "$name.ext"
chmod 644 ca.pem "$name.pem"
echo "$folder/$name.pem"
