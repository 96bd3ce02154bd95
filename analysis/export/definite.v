(* ---- A test that a form is nowhere negative, in numbers of bounded length: what a step of Lagrange's reduction cuts
   off, entries between 0 and 2^k, is made up for by 2^k times as many squares as there are variables left. ---- *)

Definition cut (k : Z) (v : list Z) : list Z := map (fun a => Z.shiftr a k) v.
Definition below (n : nat) (k : Z) (M : triangle) : triangle :=
  map (fun r => (Z.shiftr (fst r) k - Z.of_nat n, cut k (snd r))%Z) M.
Fixpoint definite (n : nat) (M : triangle) : bool :=
  match n, M with
  | O, _ => true
  | S n', (a, v) :: M' =>
      let rest := madd (mscale (2 * a) M') (product (-1) v v) in
      (0 <? a)%Z && (n' <=? length rest)%nat && definite n' (below n' (Z.log2 a + 1) rest)
  | _, [] => false
  end.
Lemma cut_off : forall k a, (0 <= k)%Z -> exists r, IZR a = IZR (2 ^ k) * IZR (Z.shiftr a k) + r /\ 0 <= r <= IZR (2 ^ k).
Proof.
  intros k a K; rewrite Z.shiftr_div_pow2 by exact K.
  pose proof (Z.pow_pos_nonneg 2 k ltac:(lia) K) as P; pose proof (Z.mod_pos_bound a (2 ^ k) P).
  exists (IZR (a mod 2 ^ k)); rewrite <- mult_IZR, <- plus_IZR, <- Z_div_mod_eq_full.
  split; [reflexivity|split; apply IZR_le; lia].
Qed.
Lemma cut_sound : forall k x v z, (0 <= k)%Z ->
  - (IZR (2 ^ k) * (INR (length z) * (x * x) + norm2 z)) <= 2 * x * (dot v z - IZR (2 ^ k) * dot (cut k v) z).
Proof.
  intros k x v z K; pose proof (IZR_le 0 _ (Z.pow_nonneg 2 k ltac:(lia))) as P.
  assert (X : 0 <= x * x) by apply Rle_0_sqr; revert z; induction v as [|a v IH]; intro z.
  - pose proof (Rmult_le_pos _ _ (pos_INR (length z)) X) as I; pose proof (norm2_nonneg z).
    pose proof (Rmult_le_pos _ _ P (Rplus_le_le_0_compat _ _ I H)); cbn [cut map dot]; lra.
  - destruct z as [|y z]; cbn [cut map dot length norm2]; [cbn [INR]; lra|].
    specialize (IH z); rewrite S_INR; destruct (cut_off k a K) as [r [-> [R0 R1]]].
    assert (Y : 0 <= y * y) by apply Rle_0_sqr.
    pose proof (Rmult_le_pos _ _ R0 (Rle_0_sqr (x + y))) as A; unfold Rsqr in A.
    pose proof (Rmult_le_pos (IZR (2 ^ k) - r) (x * x + y * y) ltac:(lra) ltac:(lra)) as B.
    unfold cut in IH; lra.
Qed.
Lemma below_sound : forall n k M z, (0 <= k)%Z -> (length z <= length M)%nat -> (length z <= n)%nat ->
  IZR (2 ^ k) * ((INR n - INR (length z)) * norm2 z) <= qf M z - IZR (2 ^ k) * qf (below n k M) z.
Proof.
  intros n k M z K; pose proof (IZR_le 0 _ (Z.pow_nonneg 2 k ltac:(lia))) as P; revert z.
  induction M as [|[a v] M IH]; intros [|x z] L N; cbn [below map qf length norm2 fst snd] in *; try lia; try lra.
  specialize (IH z ltac:(lia) ltac:(lia)); pose proof (cut_sound k x v z K) as C.
  destruct (cut_off k a K) as [r [-> [R0 R1]]]; rewrite minus_IZR, <- INR_IZR_INZ, S_INR.
  pose proof (Rmult_le_pos _ _ R0 (Rle_0_sqr x)) as X; pose proof (Rmult_le_pos _ _ P (Rle_0_sqr x)) as Y.
  unfold Rsqr in X, Y; unfold below in IH; lra.
Qed.
Lemma definite_sound : forall n M z, definite n M = true -> length z = n -> 0 <= qf M z.
Proof.
  induction n as [|n IH]; intros M z H L; destruct z as [|x z]; try discriminate.
  - destruct M as [|[a v] M]; cbn [qf]; lra.
  - destruct M as [|[a v] M]; [discriminate|]; cbn [definite] in H; cbn zeta in H; injection L as L.
    rewrite !andb_true_iff, Z.ltb_lt, Nat.leb_le in H; destruct H as [[pos long] H].
    pose proof (Z.log2_nonneg a) as K; pose proof (IH _ z H L) as D.
    pose proof (below_sound n (Z.log2 a + 1) _ z ltac:(lia) ltac:(rewrite L; exact long) ltac:(lia)) as B.
    rewrite L, Rminus_diag_eq, Rmult_0_l, Rmult_0_r, qf_add, qf_scale, qf_product, mult_IZR in B by reflexivity.
    pose proof (IZR_le 0 _ (Z.pow_nonneg 2 (Z.log2 a + 1) ltac:(lia))) as Q; pose proof (Rmult_le_pos _ _ Q D).
    apply IZR_lt in pos; cbn [qf]; apply (Rmult_le_reg_l (IZR a)); [exact pos|].
    pose proof (Rle_0_sqr (IZR a * x + dot v z)) as S0; unfold Rsqr in S0; lra.
Qed.
(* The same of numbers of which the last k digits are cut off first. *)
Definition definite_by (n : nat) (k : Z) (M : triangle) : bool := (0 <=? k)%Z && (n <=? length M)%nat && definite n (below n k M).
Lemma definite_by_sound : forall n k M z, definite_by n k M = true -> length z = n -> 0 <= qf M z.
Proof.
  intros n k M z H L; unfold definite_by in H; rewrite !andb_true_iff, Z.leb_le, Nat.leb_le in H; destruct H as [[K long] H].
  pose proof (below_sound n k M z K ltac:(lia) ltac:(lia)) as B; rewrite L, Rminus_diag_eq, Rmult_0_l, Rmult_0_r in B by reflexivity.
  pose proof (Rmult_le_pos _ _ (IZR_le 0 _ (Z.pow_nonneg 2 k ltac:(lia))) (definite_sound n _ z H L)); lra.
Qed.
